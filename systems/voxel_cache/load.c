#include "systems/voxel_cache/load.h"

#include <stdlib.h>

static bool make_room(voxel_load *l)
{
    const kd_voxel_level *level = l->level;
    size_t n = (size_t)level->voxel_count;
    uint64_t at = 0;
    l->words.shape = malloc(n * 8 + 1);
    l->words.color = malloc(n * 4 + 1);
    l->words.binding = kd_voxel_level_binds(level) ? malloc(n * 12 + 1) : NULL;
    l->starts = malloc((level->block_count + (size_t)1) * sizeof *l->starts);
    for (uint32_t i = 0; l->starts && i < level->block_count; i++) {
        l->starts[i] = (uint32_t)at;
        at += l->file->blocks[level->first_block + i].count;
    }
    return l->words.shape && l->words.color && l->starts && at <= UINT32_MAX &&
           (l->words.binding || !kd_voxel_level_binds(level));
}

static void drop(voxel_load *l)
{
    free(l->words.shape);
    free(l->words.color);
    free(l->words.binding);
    free(l->starts);
    kd_voxel_file_close(&l->own);
}

kd_status loads_add(voxel_loads *loads, uint32_t cache, kd_voxel_key key, const kd_voxel_file *given,
                    kd_voxel_file *own)
{
    if (loads->count == loads->capacity) {
        uint32_t capacity = loads->capacity ? loads->capacity * 2 : 32;
        voxel_load *grown = realloc(loads->items, capacity * sizeof *grown);
        if (!grown) {
            kd_voxel_file_close(own);
            return KD_NO_MEMORY;
        }
        loads->items = grown;
        loads->capacity = capacity;
    }
    voxel_load *l = &loads->items[loads->count];
    *l = (voxel_load){.cache = cache, .key = key, .own = *own};
    l->level = kd_voxel_file_find(given ? given : own, key);
    l->file = given ? given : own;
    bool room = make_room(l);
    l->file = given; /* NULL: its own, which moves with the list */
    if (!room) {
        drop(l);
        return KD_NO_MEMORY;
    }
    loads->count++;
    loads->voxels += l->level->voxel_count;
    return KD_OK;
}

static void unpack_block(voxel_load *l, uint32_t block)
{
    const kd_voxel_words *all = &l->words;
    size_t start = l->starts[block];
    const kd_voxel_words words = {all->shape + 2 * start, all->color + start,
                                  all->binding ? all->binding + 3 * start : NULL};
    if (kd_voxel_file_read(l->file ? l->file : &l->own, l->level->first_block + block, &words) != KD_OK)
        l->failed++;
}

static void unpack_range(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    voxel_loads *loads = user;
    (void)worker;
    for (uint32_t i = begin; i < end; i++)
        for (uint32_t b = 0; b < loads->items[i].level->block_count; b++)
            unpack_block(&loads->items[i], b);
}

void loads_unpack(voxel_loads *loads, kd_jobs *jobs)
{
    if (jobs)
        kd_jobs_parallel_for(jobs, loads->count, 1, unpack_range, loads);
    else
        unpack_range(loads, 0, loads->count, 0);
}

void loads_clear(voxel_loads *loads)
{
    for (uint32_t i = 0; i < loads->count; i++)
        drop(&loads->items[i]);
    loads->count = 0;
    loads->voxels = 0;
}

void loads_fini(voxel_loads *loads)
{
    loads_clear(loads);
    free(loads->items);
    *loads = (voxel_loads){0};
}
