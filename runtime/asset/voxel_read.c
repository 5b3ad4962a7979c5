#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <xxhash.h>
#include <zstd.h>

#include "runtime/asset/voxel_layout.h"

static kd_status refuse(char why[KD_VOXEL_WHY], kd_status status, const char *text)
{
    snprintf(why, KD_VOXEL_WHY, "%s", text);
    return status;
}

/* What is shorter than a header is cut if it begins as one does. */
static kd_status check_start(const voxel_header *h, size_t size, char why[KD_VOXEL_WHY])
{
    size_t known = size < sizeof h->magic ? size : sizeof h->magic;
    if (memcmp(h->magic, VOXEL_MAGIC, known) != 0)
        return refuse(why, KD_UNSUPPORTED, "it is no .kvox file");
    if (size < sizeof *h)
        return refuse(why, KD_BAD_FORMAT, "it is cut short: it ends within its header");
    if (h->order != VOXEL_ORDER)
        return refuse(why, h->order == 0x04030201u ? KD_UNSUPPORTED : KD_BAD_FORMAT,
                      h->order == 0x04030201u ? "it was written by a machine of another byte order"
                                              : "it is damaged: its byte order is unknown");
    if (XXH64(h, offsetof(voxel_header, header_checksum), 0) != h->header_checksum)
        return refuse(why, KD_BAD_FORMAT, "it is damaged: the header's checksum is wrong");
    if (h->version != KD_VOXEL_FILE_VERSION) {
        snprintf(why, KD_VOXEL_WHY, "it has version %u of the format, this program reads %u", h->version,
                 KD_VOXEL_FILE_VERSION);
        return KD_UNSUPPORTED;
    }
    return KD_OK;
}

static kd_status check_table(const voxel_header *h, const uint8_t *data, size_t size, char why[KD_VOXEL_WHY])
{
    if (size < h->file_bytes) {
        snprintf(why, KD_VOXEL_WHY, "it is cut short: %zu of %llu bytes are there", size,
                 (unsigned long long)h->file_bytes);
        return KD_BAD_FORMAT;
    }
    uint64_t table = voxel_table_bytes(h->level_count, h->block_count);
    if (size > h->file_bytes || h->table_offset < sizeof *h || h->table_offset % 8 ||
        h->table_offset > size || size - h->table_offset != table)
        return refuse(why, KD_BAD_FORMAT, "it is damaged: its table lies outside of it");
    if (XXH64(data + h->table_offset, (size_t)table, 0) != h->table_checksum)
        return refuse(why, KD_BAD_FORMAT, "it is damaged: the table's checksum is wrong");
    return KD_OK;
}

static bool block_is_sound(const kd_voxel_block *b, uint32_t level, uint64_t table_offset)
{
    uint64_t cells = 1;
    for (int k = 0; k < 3; k++) {
        if (!isfinite(b->origin[k]) || b->size[k] == 0 || b->size[k] > KD_VOXEL_FILE_CELLS)
            return false;
        cells *= b->size[k];
    }
    return b->level == level && b->count && b->count <= cells && b->count <= KD_VOXEL_FILE_VOXELS &&
           b->offset >= sizeof(voxel_header) && b->offset <= table_offset &&
           b->bytes <= table_offset - b->offset;
}

static bool level_is_sound(const kd_voxel_file *f, uint32_t number, uint64_t table_offset)
{
    const kd_voxel_level *l = &f->levels[number];
    if (l->kind > 2 || !(l->span > 0) || !isfinite(l->span + l->phase[0] + l->phase[1] + l->phase[2]) ||
        l->first_block > f->block_count || l->block_count > f->block_count - l->first_block)
        return false;
    uint64_t voxels = 0;
    for (uint32_t i = 0; i < l->block_count; i++) {
        if (!block_is_sound(&f->blocks[l->first_block + i], number, table_offset))
            return false;
        voxels += f->blocks[l->first_block + i].count;
    }
    return voxels == l->voxel_count;
}

kd_status kd_voxel_file_parse(kd_voxel_file *file, const void *data, size_t size, char why[KD_VOXEL_WHY])
{
    const voxel_header *h = data;
    *file = (kd_voxel_file){0};
    why[0] = '\0';
    if (size == 0)
        return refuse(why, KD_BAD_FORMAT, "it is empty");
    kd_status status = check_start(h, size, why);
    if (!status)
        status = check_table(h, data, size, why);
    if (status)
        return status;
    const uint8_t *table = (const uint8_t *)data + h->table_offset;
    kd_voxel_file f = {.map = {data, size}, .level_count = h->level_count, .block_count = h->block_count};
    f.levels = (const kd_voxel_level *)(const void *)table;
    f.blocks = (const kd_voxel_block *)(const void *)(f.levels + f.level_count);
    for (uint32_t i = 0; i < f.level_count; i++)
        if (!level_is_sound(&f, i, h->table_offset))
            return refuse(why, KD_BAD_FORMAT, "it is damaged: its table contradicts itself");
    *file = f;
    return KD_OK;
}

kd_status kd_voxel_file_open(kd_voxel_file *file, const char *path, char why[KD_VOXEL_WHY])
{
    kd_file_map map;
    *file = (kd_voxel_file){0};
    kd_status status = kd_file_map_open(&map, path);
    if (status)
        return refuse(why, status, status == KD_UNSUPPORTED ? "it is no plain file" : kd_status_text(status));
    status = kd_voxel_file_parse(file, map.data, map.size, why);
    if (status)
        kd_file_map_close(&map);
    return status;
}

void kd_voxel_file_close(kd_voxel_file *file)
{
    kd_file_map_close(&file->map);
    *file = (kd_voxel_file){0};
}

const kd_voxel_level *kd_voxel_file_find(const kd_voxel_file *file, kd_voxel_key key)
{
    for (uint32_t i = 0; i < file->level_count; i++)
        if (file->levels[i].key.low == key.low && file->levels[i].key.high == key.high)
            return &file->levels[i];
    return NULL;
}

bool kd_voxel_level_binds(const kd_voxel_level *level)
{
    return level->kind != 0;
}

kd_status kd_voxel_file_read(const kd_voxel_file *file, uint32_t block, const kd_voxel_words *words)
{
    const kd_voxel_block *b = &file->blocks[block];
    const uint8_t *packed = (const uint8_t *)file->map.data + b->offset;
    size_t raw_bytes = voxel_raw_bytes(b->count, words->binding != NULL);
    if (XXH64(packed, (size_t)b->bytes, 0) != b->checksum ||
        ZSTD_getFrameContentSize(packed, (size_t)b->bytes) != raw_bytes)
        return KD_BAD_FORMAT;
    uint8_t *raw = malloc(raw_bytes);
    if (!raw)
        return KD_NO_MEMORY;
    bool sound = ZSTD_decompress(raw, raw_bytes, packed, (size_t)b->bytes) == raw_bytes &&
                 voxel_unpack(raw, b->count, b->size, words);
    free(raw);
    return sound ? KD_OK : KD_BAD_FORMAT;
}
