#ifndef KD_APP_VOXEL_BENCH_DUMP_H
#define KD_APP_VOXEL_BENCH_DUMP_H

/* What a rig's voxel scene holds, as tables of fixed rows in a folder; docs/voxel_dumps.md describes them. */

#include "runtime/app/voxel_bench/rig.h"
#include "runtime/core/file.h"
#include "runtime/core/json.h"

/* A column as numpy names it: "<i4", "<u4", "<f4". Every type has four bytes. */
typedef struct dump_column {
    const char *name, *type;
} dump_column;

typedef struct dump {
    const rig *rig;
    const char *folder;
    kd_json tables; /* rows of "tables" in index.json */
    kd_file_out file;
    uint64_t rows; /* of the file at hand */
} dump;

/** Write everything that the last frame left. `folder` is made; what is in it stays.
 *  Errors with one message: a table stands there already, no permission, no room; index.json then lacks */
kd_status dump_write(const rig *r, const char *folder);

/* ---- tables: begin, rows, end ---- */
kd_status dump_begin(dump *d, const char *name);
/** Add a row of so many columns. Failures show at the end. */
void dump_row(dump *d, const void *row, size_t size);
/** `columns` ends with a NULL name. */
kd_status dump_end(dump *d, const char *name, const dump_column *columns);

/* ---- what there is ---- */
kd_status dump_leaves(dump *d);
kd_status dump_nodes(dump *d);
kd_status dump_pages(dump *d);
kd_status dump_caches(dump *d);
kd_status dump_objects(dump *d);

/** Read `size` bytes of a buffer back; free() them. Returns NULL when memory is out, with a message */
void *dump_read(const dump *d, kd_gpu_buffer buffer, size_t offset, size_t size);

#endif
