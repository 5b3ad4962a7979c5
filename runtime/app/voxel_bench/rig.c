#include "runtime/app/voxel_bench/rig.h"

#include <stdlib.h>
#include <string.h>

#include "components/camera.h"
#include "components/mesh_instance.h"
#include "components/render_targets.h"
#include "components/svo.h"
#include "components/transform.h"
#include "components/voxel_scene.h"
#include "runtime/app/console.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/world_setup.h"
#include "runtime/core/log.h"
#include "runtime/ecs/query.h"

const char *const rig_stage_names[RIG_STAGE_COUNT] = {
    [RIG_IO] = "io", [RIG_TRANSFORM] = "transform", [RIG_BUILD] = "reconstruct", [RIG_FILTER] = "average"};

/* ---- opening ---- */

/* A small picture, so that what is measured is the voxels. Light of lamps alone, as in the paper: light that
 * bounces on changes radiance, and so the filter's work, everywhere. The command line may say otherwise. */
static const char *const own_sets[] = {"light.bounces=1", "light.shadow_size=256"};
enum { OWN_SETS = sizeof own_sets / sizeof *own_sets, WIDTH = 64, HEIGHT = 36 };

static kd_status join_sets(rig *r, const app_options *options, const char *const *sets)
{
    uint32_t more = 0;
    while (sets[more])
        more++;
    r->sets = calloc(OWN_SETS + options->set_count + more + 1, sizeof *r->sets);
    if (!r->sets)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    memcpy(r->sets, own_sets, sizeof own_sets);
    if (options->set_count)
        memcpy(r->sets + OWN_SETS, options->sets, options->set_count * sizeof *r->sets);
    memcpy(r->sets + OWN_SETS + options->set_count, sets, more * sizeof *r->sets);
    r->options.sets = r->sets;
    r->options.set_count = OWN_SETS + options->set_count + more;
    return KD_OK;
}

static kd_status open_timing(rig *r)
{
    bool software = kd_gpu_get_info(r->gpu)->software;
    return app_timing_open(&r->timing, &(app_timing_desc){.schedule = r->schedule,
                                                          .gpu = r->gpu,
                                                          .world = r->world,
                                                          .jobs = r->jobs,
                                                          .mode = software || r->options.profile_sync
                                                                      ? APP_TIMING_SYNC
                                                                      : APP_TIMING_STAMPS});
}

static kd_status open_schedule(rig *r)
{
    r->schedule = kd_schedule_make(r->world, r->jobs, r->gpu);
    if (!r->schedule)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = app_import_systems(r->schedule, r->options.extension);
    if (status == KD_OK)
        status = open_timing(r);
    if (status == KD_OK)
        status = kd_schedule_init(r->schedule);
    if (status == KD_OK)
        kd_schedule_set_step(r->schedule, 1 / r->scene.fps);
    return status;
}

static kd_status open_all(rig *r, const app_options *options, const char *const *sets)
{
    kd_status status = join_sets(r, options, sets);
    if (status != KD_OK)
        return status;
    r->jobs = kd_jobs_make(options->threads);
    r->world = kd_world_make();
    if (!r->jobs || !r->world)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    status = app_scene_load(&r->scene, r->world, &r->options, NULL);
    if (status == KD_OK)
        status = kd_gpu_open(
            &(kd_gpu_desc){.api = options->context, .shaders = app_shaders(options->extension)}, &r->gpu);
    return status == KD_OK ? open_schedule(r) : status;
}

kd_status rig_open(rig *r, const app_options *options, const char *scene, const char *const *sets)
{
    *r = (rig){.options = *options};
    r->options.subject = scene;
    r->options.width = WIDTH;
    r->options.height = HEIGHT;
    r->options.gi = KD_GI_CONES; /* who gathers nothing builds no tree */
    app_console_warnings(&r->warnings_before);
    kd_status status = open_all(r, options, sets);
    if (status != KD_OK)
        rig_close(r);
    return status;
}

void rig_close(rig *r)
{
    if (r->schedule)
        kd_schedule_destroy(r->schedule);
    app_timing_close(&r->timing);
    if (r->scene.world)
        app_scene_fini(&r->scene);
    if (r->world)
        kd_world_destroy(r->world);
    if (r->gpu)
        kd_gpu_close(r->gpu);
    if (r->jobs)
        kd_jobs_destroy(r->jobs);
    free(r->sets);
    *r = (rig){0};
}

/* ---- running ---- */

static kd_status run_frame(rig *r)
{
    if (app_interrupted())
        return KD_INTERRUPTED;
    app_timing_frame_begin(&r->timing);
    kd_status status = app_scene_step(&r->scene, r->frame++);
    if (status == KD_OK)
        status = kd_schedule_run(r->schedule);
    if (status == KD_OK && kd_gpu_failed(r->gpu))
        status = KD_GPU;
    app_timing_section(&r->timing, APP_ROW_END, true);
    kd_gpu_end_frame(r->gpu);
    app_timing_frame_end(&r->timing);
    return status;
}

kd_status rig_run(rig *r, uint32_t frames)
{
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < frames && status == KD_OK; i++)
        status = run_frame(r);
    return status;
}

/* ---- figures ---- */

static int stage_of(kd_phase phase)
{
    switch (phase) {
    case KD_PHASE_VOXEL_IO: return RIG_IO;
    case KD_PHASE_VOXEL_TRANSFORM:
    case KD_PHASE_VOXEL_AGAIN: return RIG_TRANSFORM;
    case KD_PHASE_SVO_AGAIN:
    case KD_PHASE_SVO_BUILD: return RIG_BUILD;
    case KD_PHASE_SVO_FILTER:
    case KD_PHASE_BOUNCE_FILTER: return RIG_FILTER;
    default: return -1;
    }
}

static void add_times(const rig *r, rig_figures *out)
{
    kd_profile_stats whole = kd_profile_frame_stats(r->timing.profile);
    out->frame = (rig_time){whole.median_ms, whole.min_ms, whole.max_ms};
    for (uint32_t i = 0; i < kd_schedule_count(r->schedule); i++) {
        int stage = stage_of(kd_schedule_system(r->schedule, i)->phase);
        if (stage < 0)
            continue;
        kd_profile_stats s = kd_profile_system_stats(r->timing.profile, i);
        out->stages[stage].median_ms += s.median_ms;
        out->stages[stage].min_ms += s.min_ms;
        out->stages[stage].max_ms += s.max_ms;
    }
}

static uint64_t deforming_voxels(const kd_voxel_scene *scene)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < scene->object_count; i++)
        for (uint32_t c = 0; c < scene->cascade_count; c++)
            if (scene->objects[i].alive && scene->objects[i].segment_count[c] &&
                scene->objects[i].kind != KD_VOXEL_RIGID)
                sum += scene->objects[i].voxels[c];
    return sum;
}

static uint64_t named_bytes(const rig *r, const char *prefix)
{
    enum { MOST = 256 };
    kd_gpu_memory_row rows[MOST];
    uint32_t count = kd_gpu_memory(r->gpu, rows, MOST);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        if (strncmp(rows[i].name, prefix, strlen(prefix)) == 0)
            sum += rows[i].bytes;
    return sum;
}

static uint64_t cache_bytes(const rig *r, const kd_voxel_scene *scene)
{
    return kd_gpu_buffer_size(r->gpu, scene->cache_shape) + kd_gpu_buffer_size(r->gpu, scene->cache_color) +
           kd_gpu_buffer_size(r->gpu, scene->cache_binding);
}

static void add_counts(const rig *r, rig_figures *out)
{
    const kd_voxel_scene *scene = kd_singleton(r->world, kd_voxel_scene);
    const kd_svo *svo = kd_singleton(r->world, kd_svo);
    uint32_t counts[KD_COUNT_WORDS], warnings;
    app_console_warnings(&warnings);
    out->warnings = warnings - r->warnings_before;
    out->dynamic_voxels = scene->pages[KD_LAYER_DYNAMIC].voxel_count;
    out->voxels = out->dynamic_voxels + scene->pages[KD_LAYER_STATIC].voxel_count;
    out->deforming_voxels = deforming_voxels(scene);
    out->gpu_bytes = kd_gpu_bytes(r->gpu);
    out->tree_bytes = named_bytes(r, "tree.") + named_bytes(r, "svo.");
    out->cache_bytes = cache_bytes(r, scene);
    out->page_bytes = named_bytes(r, "voxels.") - out->cache_bytes;
    if (!svo->counters.id)
        return;
    kd_gpu_barrier(r->gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(r->gpu, svo->counters, 0, counts, sizeof counts);
    out->cells = (uint64_t)counts[KD_COUNT_STATIC] + counts[KD_COUNT_DYNAMIC];
    out->layer_bytes = (uint64_t)svo->layer_words * 4;
    out->levels = svo->leaf_level - KD_DENSE_LOG2;
    for (uint32_t l = 0; l < out->levels; l++)
        for (uint32_t c = 0; c < svo->cascades; c++)
            out->nodes[l] += counts[KD_COUNT_NODES + 4 * l + c];
}

kd_status rig_measure(rig *r, uint32_t frames, rig_step *step, void *user, rig_figures *out)
{
    *out = (rig_figures){0};
    app_timing_close(&r->timing); /* what came before counts no more */
    kd_status status = open_timing(r);
    for (uint32_t i = 0; i < frames && status == KD_OK; i++) {
        if (step)
            step(r, user);
        status = run_frame(r);
    }
    if (status != KD_OK)
        return status;
    app_timing_finish(&r->timing);
    add_times(r, out);
    add_counts(r, out);
    return KD_OK;
}

double rig_tree_ms(const rig_figures *f)
{
    return f->stages[RIG_TRANSFORM].median_ms + f->stages[RIG_BUILD].median_ms +
           f->stages[RIG_FILTER].median_ms;
}

double rig_total_ms(const rig_figures *f)
{
    return f->stages[RIG_IO].median_ms + rig_tree_ms(f);
}

/* ---- what is seen, and from where ---- */

kd_status rig_take_camera(rig *r, kd_vec3 eye, kd_vec3 target, kd_entity *camera)
{
    kd_query *q = kd_query_make(r->world, &(kd_query_desc){.terms = {KD_WRITE(kd_camera)}});
    if (!q)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        kd_camera *cameras = KD_COLUMN_MUT(&it, kd_camera, 0);
        for (uint32_t i = 0; i < it.count; i++)
            cameras[i].inactive = true;
    }
    kd_query_destroy(q);
    kd_vec3 ahead = kd_vec3_normalize(kd_vec3_sub(target, eye), (kd_vec3){0, 0, -1});
    kd_quat rotation = kd_quat_normalize((kd_quat){0, -ahead.x, 0, 1 - ahead.z}); /* -Z to `ahead`, level */
    *camera = kd_spawn(r->world, KD_VAL(kd_camera, {.fov_y = 1, .z_near = 0.05f, .z_far = 500}),
                       KD_VAL(kd_transform, {eye, rotation, {1, 1, 1}}), KD_TAG(kd_world_transform));
    return camera->generation ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory");
}

kd_status rig_hide_all(rig *r)
{
    kd_query *q = kd_query_make(r->world, &(kd_query_desc){.terms = {KD_WRITE(kd_mesh_instance)}});
    if (!q)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        kd_mesh_instance *meshes = KD_COLUMN_MUT(&it, kd_mesh_instance, 0);
        for (uint32_t i = 0; i < it.count; i++)
            meshes[i].hidden = true;
    }
    kd_query_destroy(q);
    return KD_OK;
}
