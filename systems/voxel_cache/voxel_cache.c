/* System voxel_cache: voxelizes what system voxel_objects asked for (entries of kd_voxel_scene.caches that
 * are not made yet), in model space, once per primitive and span. A steady frame finds nothing to do. */
#include "systems/voxel_cache/voxel_cache.h"

#include <math.h>
#include <stdlib.h>

#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "systems/voxel_cache/voxelizer.h"

enum { CHUNK_CELLS = 1024 };

typedef struct cache_state {
    voxelizer voxelizer;
    uint32_t made; /* caches below this number are made */
} cache_state;

static kd_voxel_chunk *push_chunk(kd_voxel_scene *scene)
{
    if ((scene->chunk_count & (scene->chunk_count - 1)) == 0) { /* room doubles at powers of two */
        uint32_t capacity = scene->chunk_count ? scene->chunk_count * 2 : 1;
        kd_voxel_chunk *grown = realloc(scene->chunks, capacity * sizeof *grown);
        if (!grown)
            return NULL;
        scene->chunks = grown;
    }
    kd_voxel_chunk *chunk = &scene->chunks[scene->chunk_count++];
    *chunk = (kd_voxel_chunk){0};
    return chunk;
}

/* Cells [low, high) whose low corners lie in a tile. */
static void cut_to_tile(const kd_voxel_cache *cache, int64_t low[3], int64_t high[3])
{
    const int32_t *tile = &cache->tile.x;
    const float *phase = &cache->phase.x;
    for (int k = 0; k < 3; k++) {
        int64_t from = (int64_t)ceilf(((float)tile[k] * cache->tile.edge - phase[k]) / cache->span);
        int64_t to = (int64_t)ceilf(((float)(tile[k] + 1) * cache->tile.edge - phase[k]) / cache->span);
        low[k] = low[k] > from ? low[k] : from;
        high[k] = high[k] < to ? high[k] : to;
    }
}

/* Lattice cells [low, high) of the primitive's bounds, counted from the phase; one cell of margin for the
 * nudge. */
static void lattice_range(const kd_voxel_cache *cache, const kd_primitive_desc *desc, int64_t low[3],
                          int64_t high[3])
{
    const float *a = &desc->bounds_min.x, *b = &desc->bounds_max.x, *phase = &cache->phase.x;
    for (int k = 0; k < 3; k++) {
        low[k] = (int64_t)floorf((a[k] - phase[k]) / cache->span);
        high[k] = (int64_t)floorf((b[k] - phase[k]) / cache->span + (float)KD_VOXELIZE_NUDGE) + 1;
        if (high[k] <= low[k])
            high[k] = low[k] + 1;
    }
    if (cache->tile.tiled)
        cut_to_tile(cache, low, high);
}

static kd_status make_chunk(kd_gpu *gpu, cache_state *state, const kd_scene_store *store,
                            kd_voxel_scene *scene, kd_voxel_cache *cache, const int64_t at[3],
                            const int64_t high[3])
{
    kd_voxel_chunk *chunk = push_chunk(scene);
    if (!chunk)
        return KD_NO_MEMORY;
    float *origin = &chunk->origin.x;
    const float *phase = &cache->phase.x;
    chunk->span = cache->span;
    for (int k = 0; k < 3; k++) {
        int64_t size = high[k] - at[k];
        chunk->size[k] = (uint32_t)(size < CHUNK_CELLS ? size : CHUNK_CELLS);
        origin[k] = phase[k] + (float)at[k] * cache->span;
    }
    kd_status status = voxelizer_run(gpu, &state->voxelizer, store, cache, scene, chunk);
    if (status || chunk->count == 0)
        scene->chunk_count--;
    else {
        cache->chunk_count++;
        cache->voxel_count += chunk->count;
    }
    return status;
}

/* Objects longer than a chunk are cut into several; none is dropped. */
static kd_status make_cache(kd_gpu *gpu, cache_state *state, const kd_scene_store *store,
                            kd_voxel_scene *scene, kd_voxel_cache *cache)
{
    int64_t low[3], high[3], at[3];
    lattice_range(cache, cache->desc, low, high);
    cache->first_chunk = scene->chunk_count;
    cache->chunk_count = 0;
    cache->voxel_count = 0;
    kd_status status = KD_OK;
    for (at[2] = low[2]; at[2] < high[2] && !status; at[2] += CHUNK_CELLS)
        for (at[1] = low[1]; at[1] < high[1] && !status; at[1] += CHUNK_CELLS)
            for (at[0] = low[0]; at[0] < high[0] && !status; at[0] += CHUNK_CELLS)
                status = make_chunk(gpu, state, store, scene, cache, at, high);
    cache->made = true;
    return status;
}

static void upload_chunks(kd_gpu *gpu, kd_voxel_scene *scene, uint32_t first)
{
    size_t size = sizeof(struct kd_voxel_chunk_params);
    size_t have = scene->chunk_params.id ? kd_gpu_buffer_size(gpu, scene->chunk_params) : 0;
    if (have < scene->chunk_count * size &&
        kd_gpu_ensure_buffer(gpu, &scene->chunk_params, (size_t)scene->chunk_count * 2 * size, first * size,
                             "voxels.chunks"))
        return;
    for (uint32_t i = first; i < scene->chunk_count; i++) {
        const kd_voxel_chunk *c = &scene->chunks[i];
        struct kd_voxel_chunk_params params = {.origin = {c->origin.x, c->origin.y, c->origin.z, c->span},
                                               .info = {c->first, c->count, c->first_binding, 0}};
        kd_gpu_write_buffer(gpu, scene->chunk_params, i * size, &params, size);
    }
}

static void run(kd_system_context *context)
{
    cache_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    uint32_t first_chunk = scene->chunk_count;
    for (; state->made < scene->cache_count && !kd_gpu_failed(context->gpu); state->made++) {
        kd_voxel_cache *cache = &scene->caches[state->made];
        kd_status status = make_cache(context->gpu, state, store, scene, cache);
        if (status)
            kd_log(KD_LOG_WARNING,
                   "a primitive could not be voxelized: %s; it will not take part in indirect light",
                   kd_status_text(status));
    }
    if (scene->chunk_count > first_chunk)
        upload_chunks(context->gpu, scene, first_chunk);
}

static bool anything_to_do(kd_system_context *context)
{
    const cache_state *state = context->user;
    return state->made < kd_singleton(context->world, kd_voxel_scene)->cache_count;
}

static kd_status init(kd_system_context *context)
{
    cache_state *state = context->user;
    return voxelizer_init(context->gpu, &state->voxelizer);
}

static void fini(kd_system_context *context)
{
    cache_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_gpu_buffer *buffers[] = {&scene->cache_shape, &scene->cache_color, &scene->cache_binding,
                                &scene->chunk_params};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        kd_gpu_destroy_buffer(context->gpu, *buffers[i]);
        *buffers[i] = (kd_gpu_buffer){0};
    }
    voxelizer_fini(context->gpu, &state->voxelizer);
    free(scene->chunks);
    scene->chunks = NULL;
    scene->chunk_count = 0;
    free(state);
}

kd_status kd_voxel_cache_import(kd_schedule *s)
{
    cache_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "voxel_cache",
                                  .phase = KD_PHASE_VOXEL_IO,
                                  .where = KD_ON_GPU,
                                  .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_scene_store)},
                                  .resources = {{"scene.vertices", KD_USE_STORAGE_READ},
                                                {"scene.indices", KD_USE_STORAGE_READ},
                                                {"scene.static", KD_USE_STORAGE_READ},
                                                {"voxels.cache", KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE},
                                                {"voxels.chunks", KD_USE_COPY_WRITE}},
                                  .run_if = anything_to_do,
                                  .no_commands = true,
                                  .run = run,
                                  .init = init,
                                  .fini = fini,
                                  .user = state,
                              });
}
