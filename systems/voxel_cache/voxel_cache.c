/* System voxel_cache: makes the caches that system voxel_objects asked for (entries of kd_voxel_scene.caches
 * that are not made yet), in model space, once per primitive and span; those that are not needed yet a few a
 * frame. A steady frame finds nothing to do. */
#include "systems/voxel_cache/voxel_cache.h"

#include <stdlib.h>

#include "components/frame.h"
#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "runtime/core/progress.h"
#include "runtime/jobs/jobs.h"
#include "systems/voxel_cache/disk.h"
#include "systems/voxel_cache/key.h"
#include "systems/voxel_cache/load.h"
#include "systems/voxel_cache/maker.h"
#include "systems/voxel_cache/plan.h"

/* Frames without work after which working memory is freed and the cache cut to what is in use. */
#define REST_FRAMES 64

/* Voxels that are unpacked before they go to the GPU: bounds the memory they take on the way. */
#define LOAD_VOXELS (4u << 20)

typedef struct cache_state {
    cache_maker maker;
    voxel_keys keys;
    voxel_disk disk;
    voxel_loads loads;
    voxel_plan plan;
    kd_job_counter saving; /* files that are being written */
    uint32_t idle_frames;
} cache_state;

static void warn(kd_status status)
{
    if (status)
        kd_log(KD_LOG_WARNING,
               "a primitive could not be voxelized whole: %s; indirect light lacks what is missing",
               kd_status_text(status));
}

/* ---- saving: packed here, written by a worker ---- */

typedef struct save {
    voxel_disk *disk;
    kd_voxel_key key;
    kd_voxel_writer writer;
} save;

static void run_save(void *user, uint32_t worker)
{
    save *s = user;
    size_t size = 0;
    const void *bytes = kd_voxel_writer_finish(&s->writer, &size);
    (void)worker;
    if (bytes)
        disk_save(s->disk, s->key, bytes, size);
    kd_voxel_writer_fini(&s->writer);
    free(s);
}

static void save_cache(kd_system_context *context, cache_state *state, const kd_voxel_scene *scene,
                       const kd_voxel_cache *cache, kd_voxel_key key)
{
    save *s = state->disk.folder[0] && !state->disk.broken ? calloc(1, sizeof *s) : NULL;
    if (!s)
        return;
    s->disk = &state->disk;
    s->key = key;
    kd_status status = maker_write(context->gpu, scene, cache, (kd_voxel_level){.key = key}, &s->writer);
    if (status != KD_OK) {
        kd_voxel_writer_fini(&s->writer);
        free(s);
        return;
    }
    if (context->jobs) { /* one at a time, in order */
        kd_jobs_wait(context->jobs, &state->saving);
        kd_jobs_run(context->jobs, run_save, s, &state->saving);
    } else {
        run_save(s, 0);
    }
}

/* ---- making ---- */

static void make_one(kd_system_context *context, cache_state *state, kd_voxel_scene *scene, uint32_t number,
                     const kd_voxel_key *key)
{
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    kd_voxel_cache *cache = &scene->caches[number];
    kd_status status = maker_make(context->gpu, &state->maker, store, scene, cache);
    scene->unmade--;
    warn(status);
    if (key && status == KD_OK && !kd_gpu_failed(context->gpu))
        save_cache(context, state, scene, cache, *key);
}

/* Bring what has been collected to the GPU; what turns out to be damaged is made anew. */
static void finish_loads(kd_system_context *context, cache_state *state, kd_voxel_scene *scene)
{
    loads_unpack(&state->loads, context->jobs);
    for (uint32_t i = 0; i < state->loads.count; i++) {
        const voxel_load *l = &state->loads.items[i];
        if (l->failed) {
            kd_log(KD_LOG_INFO, "a voxel file is damaged: a block's checksum is wrong; it is made anew");
            make_one(context, state, scene, l->cache, &l->key);
            continue;
        }
        warn(maker_load(context->gpu, &state->maker, scene, l, &scene->caches[l->cache]));
        scene->unmade--;
        scene->given_used += l->file != NULL;
    }
    loads_clear(&state->loads);
}

/* Collect a cache's level if some file has it. */
static bool find_level(cache_state *state, const kd_voxel_scene *scene, uint32_t number, kd_voxel_key key)
{
    kd_voxel_file own = {0};
    const kd_voxel_file *given = scene->given && kd_voxel_file_find(scene->given, key) ? scene->given : NULL;
    if (!given && !disk_open(&state->disk, key, &own))
        return false;
    return loads_add(&state->loads, number, key, given, &own) == KD_OK;
}

static void make_listed(kd_system_context *context, cache_state *state, kd_voxel_scene *scene)
{
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    bool files = scene->given || state->disk.folder[0];
    for (uint32_t i = 0; i < state->plan.count && !kd_gpu_failed(context->gpu); i++) {
        if (!kd_progress(i, state->plan.count, "primitives voxelized"))
            break; /* what is not made stays on the list */
        uint32_t number = state->plan.items[i].cache;
        kd_voxel_key key;
        bool keyed = files && keys_of(&state->keys, store, scene, &scene->caches[number], &key);
        if (!keyed || !find_level(state, scene, number, key))
            make_one(context, state, scene, number, keyed ? &key : NULL);
        else if (state->loads.voxels > LOAD_VOXELS)
            finish_loads(context, state, scene);
    }
    finish_loads(context, state, scene);
}

/* ---- resting ---- */

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
    if (!kd_singleton(context->world, kd_frame)->settings.voxels_cache)
        state->disk.folder[0] = '\0';
    if (scene->unmade && plan_choose(&state->plan, scene) != KD_OK)
        kd_log(KD_LOG_WARNING, "out of memory for voxel caches; indirect light lacks some");
    if (scene->unmade)
        make_listed(context, state, scene);
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
    kd_status status = maker_init(context->gpu, &state->maker);
    disk_init(&state->disk, kd_gpu_get_info(context->gpu));
    return status ? status : keys_init(&state->keys);
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
    if (context->jobs)
        kd_jobs_wait(context->jobs, &state->saving);
    disk_fini(&state->disk);
    loads_fini(&state->loads);
    plan_fini(&state->plan);
    keys_fini(&state->keys);
    maker_fini(context->gpu, &state->maker, scene);
    free(state);
}

kd_status kd_voxel_cache_import(kd_schedule *s)
{
    cache_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "voxel_cache",
               .phase = KD_PHASE_VOXEL_IO,
               .where = KD_ON_GPU,
               .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_scene_store), KD_USES(kd_frame)},
               .resources = {{"scene.vertices", KD_USE_STORAGE_READ},
                             {"scene.indices", KD_USE_STORAGE_READ},
                             {"scene.static", KD_USE_STORAGE_READ},
                             {"voxels.cache", KD_USE_STORAGE_WRITE | KD_USE_COPY_READ | KD_USE_COPY_WRITE},
                             {"voxels.chunks", KD_USE_COPY_WRITE}},
               .run_if = anything_to_do,
               .no_commands = true,
               .run = run,
               .init = init,
               .fini = fini,
               .user = state,
           });
}
