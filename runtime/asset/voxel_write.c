#include <stdlib.h>
#include <string.h>

#include <xxhash.h>
#include <zstd.h>

#include "runtime/asset/voxel_layout.h"

/* zstd's level 1 unpacks fastest and leaves little behind once bytes stand in rows. */
#define ZSTD_LEVEL 1

static bool reserve(void **items, uint32_t *capacity, uint32_t count, size_t size)
{
    if (count < *capacity)
        return true;
    uint32_t more = *capacity ? *capacity * 2 : 16;
    void *grown = realloc(*items, more * size);
    if (!grown)
        return false;
    *items = grown;
    *capacity = more;
    return true;
}

static bool reserve_bytes(kd_voxel_writer *w, size_t more)
{
    size_t want = w->size + more;
    if (want <= w->capacity)
        return true;
    size_t capacity = want > w->capacity * 2 ? want : w->capacity * 2;
    uint8_t *grown = realloc(w->bytes, capacity);
    if (!grown)
        return false;
    w->bytes = grown;
    w->capacity = capacity;
    return true;
}

/* Room for the header, which is written last. */
static bool begin(kd_voxel_writer *w)
{
    if (w->size)
        return true;
    if (!reserve_bytes(w, sizeof(voxel_header)))
        return false;
    memset(w->bytes, 0, sizeof(voxel_header));
    w->size = sizeof(voxel_header);
    return true;
}

kd_status kd_voxel_writer_level(kd_voxel_writer *w, const kd_voxel_level *level)
{
    if (!begin(w) || !reserve((void **)&w->levels, &w->level_capacity, w->level_count, sizeof *w->levels))
        return KD_NO_MEMORY;
    kd_voxel_level *l = &w->levels[w->level_count++];
    *l = *level;
    l->first_block = w->block_count;
    l->block_count = 0;
    l->voxel_count = 0;
    return KD_OK;
}

kd_status kd_voxel_writer_block(kd_voxel_writer *w, const kd_voxel_block *block, const kd_voxel_words *words)
{
    size_t raw_bytes = voxel_raw_bytes(block->count, words->binding != NULL),
           bound = ZSTD_compressBound(raw_bytes);
    if (block->count > KD_VOXEL_FILE_VOXELS)
        return KD_TOO_LARGE;
    uint8_t *raw = malloc(raw_bytes);
    if (!raw || !reserve_bytes(w, bound) ||
        !reserve((void **)&w->blocks, &w->block_capacity, w->block_count, sizeof *w->blocks)) {
        free(raw);
        return KD_NO_MEMORY;
    }
    voxel_pack(words, block->count, block->size, raw);
    size_t bytes = ZSTD_compress(w->bytes + w->size, bound, raw, raw_bytes, ZSTD_LEVEL);
    free(raw);
    if (ZSTD_isError(bytes))
        return KD_NO_MEMORY; /* the bound leaves no other reason */
    kd_voxel_block *b = &w->blocks[w->block_count++];
    kd_voxel_level *l = &w->levels[w->level_count - 1];
    *b = *block;
    b->level = w->level_count - 1;
    b->offset = w->size;
    b->bytes = bytes;
    b->checksum = XXH64(w->bytes + w->size, bytes, 0);
    w->size += bytes;
    l->block_count++;
    l->voxel_count += block->count;
    return KD_OK;
}

const void *kd_voxel_writer_finish(kd_voxel_writer *w, size_t *size)
{
    size_t levels = w->level_count * sizeof *w->levels, blocks = w->block_count * sizeof *w->blocks;
    if (!begin(w) || !reserve_bytes(w, 8 + levels + blocks))
        return NULL;
    while (w->size % 8)
        w->bytes[w->size++] = 0;
    voxel_header h = {.order = VOXEL_ORDER,
                      .version = KD_VOXEL_FILE_VERSION,
                      .table_offset = w->size,
                      .level_count = w->level_count,
                      .block_count = w->block_count};
    if (levels)
        memcpy(w->bytes + w->size, w->levels, levels);
    if (blocks)
        memcpy(w->bytes + w->size + levels, w->blocks, blocks);
    memcpy(h.magic, VOXEL_MAGIC, sizeof h.magic);
    h.table_checksum = XXH64(w->bytes + w->size, levels + blocks, 0);
    w->size += levels + blocks;
    h.file_bytes = w->size;
    h.header_checksum = XXH64(&h, offsetof(voxel_header, header_checksum), 0);
    memcpy(w->bytes, &h, sizeof h);
    *size = w->size;
    return w->bytes;
}

void kd_voxel_writer_fini(kd_voxel_writer *w)
{
    free(w->bytes);
    free(w->levels);
    free(w->blocks);
    *w = (kd_voxel_writer){0};
}
