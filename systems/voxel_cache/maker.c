/* A cache is cut into chunks of at most 1024 cells an axis, so that a cell fits 10:10:10, and of no more
 * cells and voxels than the largest buffers hold while they are made. None is dropped. */
#include "systems/voxel_cache/maker.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "systems/voxel_cache/rebind.h"

enum { CHUNK_CELLS = 1024 };

/* Cells [low, high) of a cache's lattice, counted from its phase. */
typedef struct cell_box {
    int64_t low[3], high[3];
} cell_box;

/* Cells whose low corners lie in a tile. */
static void cut_to_tile(const kd_voxel_cache *cache, cell_box *box)
{
    const int32_t *tile = &cache->tile.x;
    const float *phase = &cache->phase.x;
    for (int k = 0; k < 3; k++) {
        int64_t from = (int64_t)ceilf(((float)tile[k] * cache->tile.edge - phase[k]) / cache->span);
        int64_t to = (int64_t)ceilf(((float)(tile[k] + 1) * cache->tile.edge - phase[k]) / cache->span);
        box->low[k] = box->low[k] > from ? box->low[k] : from;
        box->high[k] = box->high[k] < to ? box->high[k] : to;
    }
}

/* Cells of the primitive's bounds; one of margin for the nudge. */
static cell_box box_of(const kd_voxel_cache *cache)
{
    const float *a = &cache->desc->bounds_min.x, *b = &cache->desc->bounds_max.x, *phase = &cache->phase.x;
    cell_box box;
    for (int k = 0; k < 3; k++) {
        box.low[k] = (int64_t)floorf((a[k] - phase[k]) / cache->span);
        box.high[k] = (int64_t)floorf((b[k] - phase[k]) / cache->span + (float)KD_VOXELIZE_NUDGE) + 1;
        if (box.high[k] <= box.low[k])
            box.high[k] = box.low[k] + 1;
    }
    if (cache->tile.tiled)
        cut_to_tile(cache, &box);
    return box;
}

static bool push_chunk(cache_maker *m, const kd_voxel_chunk *chunk)
{
    if (m->count == m->capacity) {
        uint32_t capacity = m->capacity ? m->capacity * 2 : 8;
        kd_voxel_chunk *grown = realloc(m->chunks, capacity * sizeof *grown);
        if (!grown)
            return false;
        m->chunks = grown;
        m->capacity = capacity;
    }
    m->chunks[m->count++] = *chunk;
    return true;
}

/* Give back what a chunk has taken, as there is no memory to keep it in mind. */
static kd_status give_chunk(kd_voxel_scene *scene, const kd_voxel_chunk *chunk)
{
    kd_ranges_give(&scene->voxel_places, chunk->first, chunk->count);
    if (chunk->first_binding != KD_EMPTY)
        kd_ranges_give(&scene->binding_places, chunk->first_binding, chunk->count);
    scene->cached_voxels -= chunk->count;
    return KD_NO_MEMORY;
}

/* What one cache is made with. */
typedef struct making {
    kd_gpu *gpu;
    cache_maker *maker;
    const kd_scene_store *store;
    kd_voxel_scene *scene;
    const kd_voxel_cache *cache;
} making;

static kd_status make_chunk(const making *m, const cell_box *box)
{
    kd_voxel_chunk chunk = {.span = m->cache->span};
    for (int k = 0; k < 3; k++) {
        chunk.size[k] = (uint32_t)(box->high[k] - box->low[k]);
        (&chunk.origin.x)[k] = (&m->cache->phase.x)[k] + (float)box->low[k] * m->cache->span;
    }
    kd_status status = voxelizer_run(m->gpu, &m->maker->voxelizer, m->store, m->cache, m->scene, &chunk);
    if (status || chunk.count == 0 || push_chunk(m->maker, &chunk))
        return status;
    return give_chunk(m->scene, &chunk);
}

static int longest_axis(const cell_box *box)
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (box->high[k] - box->low[k] > box->high[axis] - box->low[axis])
            axis = k;
    return axis;
}

/* Cut the longest axis, at a whole number of chunks as long as there are several, until the parts can be
 * made. */
static kd_status make_box(const making *m, const cell_box *box, bool whole)
{
    for (int k = 0; k < 3; k++)
        if (box->high[k] <= box->low[k])
            return KD_OK;
    int axis = longest_axis(box);
    int64_t size = box->high[axis] - box->low[axis];
    kd_status status = size <= CHUNK_CELLS ? make_chunk(m, box) : KD_OUT_OF_RANGE;
    if (status != KD_OUT_OF_RANGE || size == 1)
        return status == KD_OUT_OF_RANGE ? KD_TOO_LARGE : status;
    int64_t half = size > CHUNK_CELLS ? (size / 2 + CHUNK_CELLS - 1) / CHUNK_CELLS * CHUNK_CELLS : size / 2;
    cell_box low = *box, high = *box;
    low.high[axis] = high.low[axis] = box->low[axis] + half;
    if (whole && m->scene->voxelize_flags & KD_VOXEL_LEVEL_FILLED)
        return KD_UNSUPPORTED; /* what is inside shows in the whole alone */
    kd_status first = make_box(m, &low, false), second = make_box(m, &high, false);
    return first ? first : second;
}

/* Enter the maker's chunks into the scene's list. */
static kd_status enter_chunks(cache_maker *m, kd_voxel_scene *scene, kd_voxel_cache *cache)
{
    uint64_t bound = kd_ranges_bound(&scene->chunk_places, m->count);
    if (bound > m->chunk_capacity) {
        uint64_t capacity = bound > m->chunk_capacity * 2ull ? bound + 16 : m->chunk_capacity * 2ull;
        kd_voxel_chunk *grown = realloc(scene->chunks, capacity * sizeof *grown);
        if (!grown)
            return KD_NO_MEMORY;
        scene->chunks = grown;
        m->chunk_capacity = (uint32_t)capacity;
    }
    cache->first_chunk = kd_ranges_take(&scene->chunk_places, m->count);
    cache->chunk_count = m->count;
    if (m->count)
        memcpy(scene->chunks + cache->first_chunk, m->chunks, m->count * sizeof *m->chunks);
    for (uint32_t i = 0; i < m->count; i++)
        cache->voxel_count += m->chunks[i].count;
    scene->chunk_count = scene->chunk_places.end;
    return KD_OK;
}

/* So that shaders find them by number. */
static kd_status upload_chunks(kd_gpu *gpu, kd_voxel_scene *scene, const kd_voxel_cache *cache)
{
    const size_t size = sizeof(struct kd_voxel_chunk_params);
    size_t have = scene->chunk_params.id ? kd_gpu_buffer_size(gpu, scene->chunk_params) : 0;
    size_t want = (size_t)scene->chunk_count * size;
    kd_status status = KD_OK;
    if (have < want)
        status = kd_gpu_ensure_buffer(gpu, &scene->chunk_params, want * 2, have, "voxels.chunks");
    for (uint32_t i = 0; i < cache->chunk_count && !status; i++) {
        const kd_voxel_chunk *c = &scene->chunks[cache->first_chunk + i];
        struct kd_voxel_chunk_params params = {.origin = {c->origin.x, c->origin.y, c->origin.z, c->span},
                                               .info = {c->first, c->count, c->first_binding, 0}};
        kd_gpu_write_buffer(gpu, scene->chunk_params, (cache->first_chunk + i) * size, &params, size);
    }
    return status;
}

static kd_status enter(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene, kd_voxel_cache *cache)
{
    kd_status status = enter_chunks(maker, scene, cache);
    return status ? status : upload_chunks(gpu, scene, cache);
}

static void begin(cache_maker *maker, kd_voxel_cache *cache)
{
    maker->count = 0;
    cache->made = true;
    cache->chunk_count = cache->voxel_count = 0;
}

kd_status maker_make(kd_gpu *gpu, cache_maker *maker, const kd_scene_store *store, kd_voxel_scene *scene,
                     kd_voxel_cache *cache)
{
    const making m = {gpu, maker, store, scene, cache};
    cell_box box = box_of(cache);
    begin(maker, cache);
    kd_status status = make_box(&m, &box, true);
    if (voxelizer_flags(scene, cache) & KD_VOXEL_LEVEL_GEODESIC && maker->count && !status)
        status = rebind_geodesic(gpu, store, scene, cache, maker->chunks, maker->count, &maker->told);
    kd_status entered = enter(gpu, maker, scene, cache);
    return status ? status : entered;
}

/* ---- to and from files ---- */

static kd_status load_block(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene, const voxel_load *load,
                            uint32_t number)
{
    const kd_voxel_file *file = load->file ? load->file : &load->own;
    const kd_voxel_block *b = &file->blocks[load->level->first_block + number];
    const size_t at = load->starts[number], n = b->count, word = KD_BINDING_WORDS * 4;
    kd_voxel_chunk chunk = {.origin = {b->origin[0], b->origin[1], b->origin[2]},
                            .span = load->level->span,
                            .size = {b->size[0], b->size[1], b->size[2]}};
    kd_status status = voxelizer_take(gpu, scene, b->count, load->words.binding ? b->count : 0, &chunk);
    if (status)
        return status;
    kd_gpu_write_buffer(gpu, scene->cache_shape, (size_t)chunk.first * 8, load->words.shape + 2 * at, n * 8);
    kd_gpu_write_buffer(gpu, scene->cache_color, (size_t)chunk.first * 4, load->words.color + at, n * 4);
    if (load->words.binding)
        kd_gpu_write_buffer(gpu, scene->cache_binding, chunk.first_binding * word,
                            load->words.binding + KD_BINDING_WORDS * at, n * word);
    return push_chunk(maker, &chunk) ? KD_OK : give_chunk(scene, &chunk);
}

kd_status maker_load(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene, const voxel_load *load,
                     kd_voxel_cache *cache)
{
    kd_status status = KD_OK;
    begin(maker, cache);
    for (uint32_t i = 0; i < load->level->block_count && !status; i++)
        status = load_block(gpu, maker, scene, load, i);
    kd_status entered = enter(gpu, maker, scene, cache);
    return status ? status : entered;
}

static kd_status write_chunk(kd_gpu *gpu, const kd_voxel_scene *scene, const kd_voxel_chunk *c,
                             kd_voxel_writer *writer)
{
    const size_t n = c->count, word = KD_BINDING_WORDS * 4;
    bool binds = c->first_binding != KD_EMPTY;
    uint32_t *memory = malloc(n * 12 + (binds ? n * word : 0));
    if (!memory)
        return KD_NO_MEMORY;
    const kd_voxel_words words = {memory, memory + 2 * n, binds ? memory + 3 * n : NULL};
    kd_gpu_read_buffer(gpu, scene->cache_shape, (size_t)c->first * 8, words.shape, n * 8);
    kd_gpu_read_buffer(gpu, scene->cache_color, (size_t)c->first * 4, words.color, n * 4);
    if (binds)
        kd_gpu_read_buffer(gpu, scene->cache_binding, c->first_binding * word, words.binding, n * word);
    const kd_voxel_block block = {.origin = {c->origin.x, c->origin.y, c->origin.z},
                                  .size = {c->size[0], c->size[1], c->size[2]},
                                  .count = c->count};
    kd_status status = kd_voxel_writer_block(writer, &block, &words);
    free(memory);
    return status;
}

kd_status maker_write(kd_gpu *gpu, const kd_voxel_scene *scene, const kd_voxel_cache *cache,
                      kd_voxel_level level, kd_voxel_writer *writer)
{
    level.kind = cache->kind;
    level.flags = voxelizer_flags(scene, cache);
    level.span = cache->span;
    memcpy(level.phase, &cache->phase, sizeof level.phase);
    kd_status status = kd_voxel_writer_level(writer, &level);
    for (uint32_t i = 0; i < cache->chunk_count && !status; i++)
        status = write_chunk(gpu, scene, &scene->chunks[cache->first_chunk + i], writer);
    return status;
}

kd_status maker_init(kd_gpu *gpu, cache_maker *maker)
{
    return voxelizer_init(gpu, &maker->voxelizer);
}

void maker_fini(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene)
{
    voxelizer_fini(gpu, &maker->voxelizer);
    free(maker->chunks);
    free(scene->chunks);
    scene->chunks = NULL;
    scene->chunk_count = 0;
    *maker = (cache_maker){0};
}
