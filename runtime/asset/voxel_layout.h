#ifndef KD_ASSET_VOXEL_LAYOUT_H
#define KD_ASSET_VOXEL_LAYOUT_H

/* The layout of .kvox files that reader and writer share. */

#include <stddef.h>

#include "runtime/asset/voxel_file.h"

/* Line ends and a byte above 127 show what a transfer as text has spoilt. */
#define VOXEL_MAGIC "KVOX\r\n\x1a\xf0"
#define VOXEL_ORDER 0x01020304u

typedef struct voxel_header {
    char magic[8];
    uint32_t order, version;
    uint64_t file_bytes;
    uint64_t table_offset; /* a multiple of 8; the table reaches to the end */
    uint32_t level_count, block_count;
    uint64_t table_checksum;
    uint64_t header_checksum; /* of the bytes before */
} voxel_header;
_Static_assert(sizeof(voxel_header) == 56 && sizeof(kd_voxel_level) == 64 && sizeof(kd_voxel_block) == 56,
               "no padding: these structs are the file's layout");

static inline size_t voxel_table_bytes(uint32_t levels, uint32_t blocks)
{
    return levels * sizeof(kd_voxel_level) + blocks * sizeof(kd_voxel_block);
}

/** Bytes of `count` voxels before compression. */
static inline size_t voxel_raw_bytes(uint32_t count, bool binds)
{
    return (size_t)count * (binds ? 24 : 12);
}

/** Place of a cell in the order of a block's voxels, and back: 8x8x8 cells together, in rows along x, y, z,
 * Morton order inside, as shaders/voxel_cache/chunk_cell.glsl has it. Returns false when there is no such
 * cell. */
uint64_t voxel_cell_place(const uint32_t size[3], uint32_t cell);
bool voxel_place_cell(const uint32_t size[3], uint64_t place, uint32_t *cell);

/** Put words into rows of bytes, cells as differences of their places. */
void voxel_pack(const kd_voxel_words *words, uint32_t count, const uint32_t size[3], uint8_t *raw);
/** Take them out again. Returns false when a cell is outside `size` or not above the one before. */
bool voxel_unpack(const uint8_t *raw, uint32_t count, const uint32_t size[3], const kd_voxel_words *words);

#endif
