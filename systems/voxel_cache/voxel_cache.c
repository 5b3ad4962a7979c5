/* System voxel_cache: makes the caches that system voxel_objects asked for (entries of kd_voxel_scene.caches that are not made
 * yet), in model space, once per primitive and span. A steady frame finds nothing to do. */
#include "systems/voxel_cache/voxel_cache.h"

#include <stdlib.h>

#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "systems/voxel_cache/maker.h"

/* Frames without work after which working memory is freed and the cache cut to what is in use. */
#define REST_FRAMES 64

typedef struct cache_state {
    cache_maker maker;
    uint32_t idle_frames;
} cache_state;

static void make_wanted(kd_system_context *context, cache_state *state, kd_voxel_scene *scene)
{
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    for (uint32_t i = 0; i < scene->cache_count && scene->unmade && !kd_gpu_failed(context->gpu); i++) {
        kd_voxel_cache *cache = &scene->caches[i];
        if (!cache->alive || cache->made)
            continue;
        kd_status status = maker_make(context->gpu, &state->maker, store, scene, cache);
        scene->unmade--;
        if (status)
            kd_log(KD_LOG_WARNING,
                   "a primitive could not be voxelized whole: %s; indirect light lacks what is missing",
                   kd_status_text(status));
    }
}

/* What lies beyond the places in use, when it is more than a sixteenth: less is not worth a copy. */
static bool has_slack(const kd_gpu *gpu, kd_gpu_buffer buffer, size_t used)
{
    size_t have = buffer.id ? kd_gpu_buffer_size(gpu, buffer) : 0;
    return have > used + used / 16 + 4096;
}

static void trim(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t used, const char *name)
{
    if (!has_slack(gpu, *buffer, used))
        return;
    kd_gpu_buffer tight =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = used ? used : 64, .name = name});
    if (!tight.id)
        return; /* the larger one serves on */
    kd_gpu_copy_buffer(gpu, *buffer, 0, tight, 0, used);
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = tight;
}

static void rest(kd_gpu *gpu, cache_state *state, kd_voxel_scene *scene)
{
    voxelizer_rest(gpu, &state->maker.voxelizer);
    trim(gpu, &scene->cache_shape, (size_t)scene->voxel_places.end * 8, "voxels.shape");
    trim(gpu, &scene->cache_color, (size_t)scene->voxel_places.end * 4, "voxels.color");
    trim(gpu, &scene->cache_binding, (size_t)scene->binding_places.end * KD_BINDING_WORDS * 4,
         "voxels.binding");
}

static void run(kd_system_context *context)
{
    cache_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    if (scene->unmade)
        make_wanted(context, state, scene);
    else
        rest(context->gpu, state, scene);
}

static bool anything_to_do(kd_system_context *context)
{
    cache_state *state = context->user;
    const kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    if (scene->unmade) {
        state->idle_frames = 0;
        return true;
    }
    if (state->idle_frames < REST_FRAMES)
        return ++state->idle_frames == REST_FRAMES && scene->cache_shape.id;
    return has_slack(context->gpu, scene->cache_shape, (size_t)scene->voxel_places.end * 8);
}

static kd_status init(kd_system_context *context)
{
    cache_state *state = context->user;
    return maker_init(context->gpu, &state->maker);
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
    maker_fini(context->gpu, &state->maker, scene);
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
                                                {"voxels.cache",
                                                 KD_USE_STORAGE_WRITE | KD_USE_COPY_READ | KD_USE_COPY_WRITE},
                                                {"voxels.chunks", KD_USE_COPY_WRITE}},
                                  .run_if = anything_to_do,
                                  .no_commands = true,
                                  .run = run,
                                  .init = init,
                                  .fini = fini,
                                  .user = state,
                              });
}
