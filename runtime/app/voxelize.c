/* The scene is brought to its first frame, the system that asks for caches asks for all of them, and each is
 * made, read back and dropped again, so that a scene larger than the GPU's memory can be voxelized too. */
#include "runtime/app/voxelize.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/frame.h"
#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/app/console.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/scene.h"
#include "runtime/asset/voxel_file.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "systems/animation/animation.h"
#include "systems/deform/deform.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"
#include "systems/voxel_cache/distance.h"
#include "systems/voxel_cache/key.h"
#include "systems/voxel_cache/maker.h"
#include "systems/voxel_pages/voxel_pages.h"

typedef struct voxelizing {
    const app_options *options;
    kd_jobs *jobs;
    kd_world *world;
    kd_gpu *gpu;
    kd_schedule *schedule;
    app_scene scene;
    cache_maker maker;
    voxel_keys keys;
    kd_voxel_writer writer;
    bool measures; /* how far voxels are from the mesh, instead of writing them */
    voxel_distances measured;
} voxelizing;

/* ---- before ---- */

static kd_status open_schedule(voxelizing *v)
{
    static kd_status (*const imports[])(kd_schedule *) = {
        kd_scene_import, kd_animation_import, kd_hierarchy_import, kd_deform_import, kd_voxel_objects_import};
    v->schedule = kd_schedule_make(v->world, v->jobs, v->gpu);
    if (!v->schedule)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = KD_OK;
    for (size_t i = 0; i < sizeof imports / sizeof *imports && !status; i++)
        status = imports[i](v->schedule);
    return status ? status : kd_schedule_init(v->schedule);
}

static kd_status open_all(voxelizing *v)
{
    kd_file_out probe;
    const char *out = v->options->voxelizing.out;
    if (!v->measures) {
        kd_status status = kd_file_out_open(&probe, out); /* what would fail at the end */
        if (status)
            return status;
        kd_file_out_cancel(&probe);
    }
    v->jobs = kd_jobs_make(v->options->threads);
    v->world = kd_world_make();
    if (!v->jobs || !v->world)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = app_scene_load(&v->scene, v->world, v->options, NULL);
    if (!status)
        status = kd_gpu_open(&(kd_gpu_desc){.api = v->options->context}, &v->gpu);
    if (!status)
        status = open_schedule(v);
    if (!status)
        status = maker_init(v->gpu, &v->maker);
    return status ? status : keys_init(&v->keys);
}

/* The longest side of everything that is drawn. */
static float longest_side(kd_world *w)
{
    const kd_draw_list *list = kd_singleton(w, kd_draw_list);
    kd_vec3 size = kd_vec3_sub(list->bounds_max_ws, list->bounds_min_ws);
    return fmaxf(size.x, fmaxf(size.y, size.z));
}

static void apply_options(voxelizing *v)
{
    const app_voxelizing *o = &v->options->voxelizing;
    kd_settings *s = &v->scene.settings;
    v->scene.gi = KD_GI_CONES;
    v->scene.view = KD_VIEW_FINAL;
    if (o->span > 0)
        s->voxels_span = (float)o->span;
    if (o->levels)
        s->voxels_cascades = (int32_t)o->levels;
    if (o->separating)
        s->voxels_separating = o->separating;
    s->voxels_fill = s->voxels_fill || o->fill;
}

/* One frame, in which nothing is voxelized: what is wanted is listed in the scene. */
static kd_status list_caches(voxelizing *v)
{
    kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
    scene->want_all = true;
    if (v->options->voxelizing.resolution) { /* the size of what is drawn is known after a frame */
        kd_status status = kd_schedule_enable(v->schedule, "voxel_objects", false);
        if (!status)
            status = app_scene_step(&v->scene, 0);
        if (!status)
            status = kd_schedule_run(v->schedule);
        if (!status)
            status = kd_schedule_enable(v->schedule, "voxel_objects", true);
        if (status)
            return status;
        v->scene.settings.voxels_span = longest_side(v->world) / (float)v->options->voxelizing.resolution;
    }
    kd_status status = app_scene_step(&v->scene, 0);
    return status ? status : kd_schedule_run(v->schedule);
}

/* ---- the work ---- */

/* Which mesh of the store a primitive belongs to, and its number there. */
static void name_level(const kd_scene_store *store, uint32_t primitive, kd_voxel_level *level)
{
    for (uint32_t i = 0; i < store->mesh_count; i++) {
        const kd_store_mesh *m = &store->meshes[i];
        if (primitive >= m->first_primitive && primitive - m->first_primitive < m->primitive_count) {
            level->mesh = i;
            level->primitive = primitive - m->first_primitive;
        }
    }
}

static kd_status measure_level(voxelizing *v, const kd_voxel_scene *scene, const kd_voxel_cache *cache)
{
    if (cache->chunk_count != 1)
        return cache->chunk_count ? KD_TOO_LARGE : KD_OK;
    const kd_voxel_chunk *chunk = &scene->chunks[cache->first_chunk];
    uint32_t(*shape)[2] = malloc(chunk->count * sizeof *shape);
    kd_status status = shape ? KD_OK : KD_NO_MEMORY;
    if (!status) {
        kd_gpu_read_buffer(v->gpu, scene->cache_shape, (size_t)chunk->first * 8, shape,
                           chunk->count * sizeof *shape);
        status = voxel_distances_add(cache->desc, chunk, (const uint32_t(*)[2])shape, &v->measured);
    }
    free(shape);
    return status;
}

static kd_status make_level(voxelizing *v, kd_voxel_scene *scene, kd_voxel_cache *cache)
{
    const kd_scene_store *store = kd_singleton(v->world, kd_scene_store);
    kd_voxel_level level = {0};
    name_level(store, cache->primitive, &level);
    if (!keys_of(&v->keys, store, scene, cache, &level.key))
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = maker_make(v->gpu, &v->maker, store, scene, cache);
    if (!status)
        status = v->measures ? measure_level(v, scene, cache)
                             : maker_write(v->gpu, scene, cache, level, &v->writer);
    kd_voxel_cache_drop(scene, cache);
    if (kd_gpu_failed(v->gpu))
        return KD_GPU;
    if (!status || status == KD_NO_MEMORY)
        return status ? kd_fail(status, "out of memory") : KD_OK;
    const char *why =
        status == KD_UNSUPPORTED
            ? "it is too large to be filled in one piece; give a larger --span or leave --fill out"
            : "it has more voxels than the driver's buffers hold; give a larger --span";
    return kd_fail(status, "%s: mesh %u, primitive %u at a span of %g m: %s", v->options->subject, level.mesh,
                   level.primitive, (double)cache->span, why);
}

/* Runs cut what is longer into tiles round the camera; a file would hold voxels that nobody asks for. */
#define MOST_CELLS 4096

static bool too_long(const kd_voxel_cache *cache)
{
    kd_vec3 size = kd_vec3_sub(cache->desc->bounds_max, cache->desc->bounds_min);
    return fmaxf(size.x, fmaxf(size.y, size.z)) > MOST_CELLS * cache->span;
}

static kd_status make_all(voxelizing *v)
{
    kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
    kd_status status = KD_OK;
    uint32_t left_out = 0;
    if (!scene->cache_count)
        return kd_fail(KD_UNSUPPORTED, "%s: shows nothing that could be voxelized", v->options->subject);
    for (uint32_t i = 0; i < scene->cache_count && !status; i++) {
        if (app_interrupted())
            return KD_INTERRUPTED;
        if (too_long(&scene->caches[i]))
            left_out++;
        else
            status = make_level(v, scene, &scene->caches[i]);
        app_console_work(i + 1, scene->cache_count, "primitives and spans");
    }
    if (left_out && !status)
        kd_log(KD_LOG_WARNING,
               "%s: %u primitives are longer than %d voxels at one of the spans and not in the file there; "
               "runs voxelize what is "
               "near the camera",
               v->options->subject, left_out, MOST_CELLS);
    return status;
}

static kd_status write_file(voxelizing *v)
{
    size_t size = 0;
    uint64_t voxels = 0;
    const char *path = v->options->voxelizing.out;
    const void *bytes = kd_voxel_writer_finish(&v->writer, &size);
    if (!bytes)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", path);
    kd_status status = kd_file_write(path, bytes, size);
    for (uint32_t i = 0; i < v->writer.level_count; i++)
        voxels += v->writer.levels[i].voxel_count;
    if (status == KD_OK && !v->options->quiet)
        printf("%s: %u levels, %llu voxels, %.1f bytes each in the file\n", path, v->writer.level_count,
               (unsigned long long)voxels, voxels ? (double)size / (double)voxels : 0.0);
    return status;
}

static void close_all(voxelizing *v)
{
    if (v->gpu) {
        kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
        maker_fini(v->gpu, &v->maker, scene);
        kd_gpu_buffer *buffers[] = {&scene->cache_shape, &scene->cache_color, &scene->cache_binding,
                                    &scene->chunk_params};
        for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
            kd_gpu_destroy_buffer(v->gpu, *buffers[i]);
    }
    keys_fini(&v->keys);
    kd_voxel_writer_fini(&v->writer);
    if (v->schedule)
        kd_schedule_destroy(v->schedule);
    app_scene_fini(&v->scene);
    if (v->world)
        kd_world_destroy(v->world);
    if (v->gpu)
        kd_gpu_close(v->gpu);
    if (v->jobs)
        kd_jobs_destroy(v->jobs);
}

/* Voxelize everything once. */
static kd_status run(voxelizing *v)
{
    kd_status status = open_all(v);
    if (!status) {
        apply_options(v);
        status = list_caches(v);
    }
    if (!status)
        status = make_all(v);
    app_console_clear();
    return status;
}

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* One row of the table, in percent of the diagonal of the box of all that is drawn. */
static kd_status measure(const app_options *options, uint32_t resolution)
{
    app_options with = *options;
    with.voxelizing.resolution = resolution;
    with.voxelizing.levels = 1;
    with.voxelizing.span = 0;
    voxelizing v = {.options = &with, .measures = true};
    kd_status status = run(&v);
    if (!status) {
        const kd_draw_list *list = kd_singleton(v.world, kd_draw_list);
        kd_vec3 size = kd_vec3_sub(list->bounds_max_ws, list->bounds_min_ws);
        double edges = (double)kd_vec3_length(size) / (double)v.scene.settings.voxels_span / 100;
        const voxel_distances *d = &v.measured;
        printf("%-24s %5u^3 %9llu %16.4f %16.4f\n", last_part(options->subject), resolution,
               (unsigned long long)d->voxels, d->to_mesh / (double)d->voxels / edges,
               d->to_voxels / (double)d->vertices / edges);
    }
    close_all(&v);
    return status;
}

/* As Gaitatzes & Papaioannou 2012 print it, table 6.2. */
static kd_status print_distances(const app_options *options)
{
    kd_status status = KD_OK;
    printf("mean distance, %% of the diagonal of the box\n%-24s %7s %9s %16s %16s\n", "scene", "grid",
           "voxels", "voxels to mesh", "mesh to voxels");
    for (uint32_t resolution = 64; resolution <= 256 && !status; resolution *= 2)
        status = measure(options, resolution);
    return status;
}

static kd_status write_voxels(const app_options *options)
{
    voxelizing v = {.options = options};
    kd_status status = run(&v);
    if (!status)
        status = write_file(&v);
    close_all(&v);
    if (status == KD_INTERRUPTED)
        kd_log(KD_LOG_INFO, "interrupted; %s was not written", options->voxelizing.out);
    return status;
}

kd_status app_voxelize(const app_options *options)
{
    if (!options->voxelizing.out && !options->voxelizing.hausdorff)
        return kd_fail(KD_USAGE, "voxelize needs a file to write; add -o FILE.kvox");
    app_interrupt_install();
    kd_status status = options->voxelizing.out ? write_voxels(options) : KD_OK;
    return !status && options->voxelizing.hausdorff ? print_distances(options) : status;
}
