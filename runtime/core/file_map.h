#ifndef KD_CORE_FILE_MAP_H
#define KD_CORE_FILE_MAP_H

#include <stddef.h>

#include "runtime/core/status.h"

/* A file in memory without a copy: pages are read when they are touched. Starts as {0}. Files that others cut
 * while they are mapped are not guarded against; ours are replaced by rename, never changed. */
typedef struct kd_file_map {
    const void *data; /* NULL when empty */
    size_t size;
} kd_file_map;

/** Map a plain file to read. Writes no message. Errors NOT_FOUND, NO_PERMISSION, UNSUPPORTED for what is no
 * plain file, IO */
kd_status kd_file_map_open(kd_file_map *map, const char *path);
void kd_file_map_close(kd_file_map *map);

#endif
