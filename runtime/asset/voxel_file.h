#ifndef KD_ASSET_VOXEL_FILE_H
#define KD_ASSET_VOXEL_FILE_H

/* .kvox files: cached voxels of primitives.
 *
 * A file is a header, compressed blocks, and a table at the end: levels (a primitive's voxels at one span),
 * then blocks. Words are in the writer's byte order, which the header tells. The header, the table and every
 * block have a checksum of their own, so that opening a file reads its ends alone, and blocks can be read by
 * several threads at once.
 *
 * A block holds `count` voxels in the order of their cells (8x8x8 together): places of the cells in that
 * order (each less the one before), of the normals, of the colours, and three of the binding where the level
 * has one; each word's bytes in four rows; all of it through zstd. What the words mean stands in
 * shaders/shared/voxel.h. */

#include <stdbool.h>
#include <stdint.h>

#include "runtime/core/file_map.h"
#include "runtime/core/status.h"

#define KD_VOXEL_FILE_VERSION 2u
#define KD_VOXEL_FILE_CELLS   1024u      /* along an axis of a block */
#define KD_VOXEL_FILE_VOXELS  (1u << 26) /* of a block */

/* What a level was made of, hashed: equal keys, equal voxels. */
typedef struct kd_voxel_key {
    uint64_t low, high;
} kd_voxel_key;

#define KD_VOXEL_LEVEL_THIN     1u /* 6-separating; else every cell that the surface touches */
#define KD_VOXEL_LEVEL_FILLED   2u
#define KD_VOXEL_LEVEL_GEODESIC 4u /* skinned voxels are bound through the inside of the body */
typedef struct kd_voxel_level {
    kd_voxel_key key;
    uint32_t kind;  /* KD_VOXEL_* of shaders/shared/voxel.h */
    uint32_t flags; /* KD_VOXEL_LEVEL_* */
    float span;     /* model space, m */
    float phase[3]; /* a point of the voxel lattice, model space */
    uint32_t first_block, block_count;
    uint64_t voxel_count;
    uint32_t mesh, primitive; /* of the model it was made from, for people */
} kd_voxel_level;

typedef struct kd_voxel_block {
    float origin[3];  /* low corner, model space */
    uint32_t size[3]; /* cells */
    uint32_t count;   /* voxels */
    uint32_t level;
    uint64_t offset, bytes; /* in the file, compressed */
    uint64_t checksum;      /* of those bytes */
} kd_voxel_block;

/* Words of voxels. Shapes  shape: [count][2] cell, normal; color: [count]; binding: [count][3], NULL when
 * rigid */
typedef struct kd_voxel_words {
    uint32_t *shape, *color, *binding;
} kd_voxel_words;

/* ---- reading ---- */
typedef struct kd_voxel_file {
    kd_file_map map;
    uint32_t level_count, block_count;
    const kd_voxel_level *levels;
    const kd_voxel_block *blocks;
} kd_voxel_file;

#define KD_VOXEL_WHY 96 /* bytes enough for every reason */

/** Open a file: check header and table, not the blocks. Writes no message; the reason of a failure goes to
 * `why`. Errors  as kd_file_map_open; UNSUPPORTED: no .kvox file, of another version or byte order;
 * BAD_FORMAT: cut or damaged */
kd_status kd_voxel_file_open(kd_voxel_file *file, const char *path, char why[KD_VOXEL_WHY]);
/** Check and open bytes that the caller keeps, aligned to 8. */
kd_status kd_voxel_file_parse(kd_voxel_file *file, const void *data, size_t size, char why[KD_VOXEL_WHY]);
void kd_voxel_file_close(kd_voxel_file *file);

/** Find the level of a key. Returns NULL when there is none. */
const kd_voxel_level *kd_voxel_file_find(const kd_voxel_file *file, kd_voxel_key key);
/** Tell whether a level's voxels carry bindings. */
bool kd_voxel_level_binds(const kd_voxel_level *level);

/** Unpack a block. Cells are inside the block and strictly in order, whatever the file says.
 *  Errors     BAD_FORMAT, NO_MEMORY; the words are undefined then
 *  Threading  any number at once */
kd_status kd_voxel_file_read(const kd_voxel_file *file, uint32_t block, const kd_voxel_words *words);

/* ---- writing ---- */

/* A file being put together in memory. Starts as {0}. */
typedef struct kd_voxel_writer {
    uint8_t *bytes;
    size_t size, capacity;
    kd_voxel_level *levels;
    kd_voxel_block *blocks;
    uint32_t level_count, level_capacity, block_count, block_capacity;
} kd_voxel_writer;

/** Begin a level; blocks that follow belong to it. Its counts are filled in. Errors NO_MEMORY */
kd_status kd_voxel_writer_level(kd_voxel_writer *writer, const kd_voxel_level *level);
/** Add a block of origin, size and count. Errors NO_MEMORY, TOO_LARGE */
kd_status kd_voxel_writer_block(kd_voxel_writer *writer, const kd_voxel_block *block,
                                const kd_voxel_words *words);
/** Write header and table. Returns the file's bytes, which the writer keeps, or NULL when memory is out. */
const void *kd_voxel_writer_finish(kd_voxel_writer *writer, size_t *size);
void kd_voxel_writer_fini(kd_voxel_writer *writer);

#endif
