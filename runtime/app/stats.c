#include "runtime/app/stats.h"

#include <string.h>
#include <sys/resource.h>

#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/render_targets.h"
#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/app/app.h"
#include "runtime/app/console.h"
#include "runtime/core/file.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"
#include "runtime/ecs/query.h"
#include "shaders/shared/gather.h"

static void put_uint(kd_json *j, const char *key, uint64_t value)
{
    kd_json_key(j, key);
    kd_json_uint(j, value);
}

static void put_string(kd_json *j, const char *key, const char *value)
{
    kd_json_key(j, key);
    kd_json_string(j, value);
}

static void put_double(kd_json *j, const char *key, double value)
{
    kd_json_key(j, key);
    kd_json_double(j, value);
}

static uint32_t count_with(kd_world *w, const kd_component_desc *desc)
{
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {{.kind = KD_TERM_WITH, .desc = desc}}});
    uint32_t count = q ? kd_query_count(q) : 0;
    if (q)
        kd_query_destroy(q);
    return count;
}

/* Triangles over all instances. */
static uint64_t count_triangles(kd_world *w)
{
    const kd_scene_store *store = kd_singleton(w, kd_scene_store);
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance)}});
    uint64_t indices = 0;
    if (!q)
        return 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        const kd_mesh_instance *instances = KD_COLUMN(&it, kd_mesh_instance, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            const kd_store_mesh *mesh = &store->meshes[instances[i].mesh];
            for (uint32_t p = 0; p < mesh->primitive_count; p++)
                indices += store->primitives[mesh->first_primitive + p].index_count;
        }
    }
    kd_query_destroy(q);
    return indices / 3;
}

static void put_scene(kd_json *j, kd_world *w)
{
    kd_json_key(j, "scene");
    kd_json_object_begin(j);
    put_uint(j, "entities", kd_entity_count(w));
    put_uint(j, "triangles", count_triangles(w));
    put_uint(j, "skinned", count_with(w, &kd_skin_instance_desc));
    put_uint(j, "lights", count_with(w, &kd_light_desc));
    kd_json_object_end(j);
}

static void put_context(kd_json *j, const kd_gpu *gpu, const kd_jobs *jobs)
{
    const kd_gpu_info *info = kd_gpu_get_info(gpu);
    kd_json_key(j, "context");
    kd_json_object_begin(j);
    put_string(j, "api", info->api);
    put_string(j, "renderer", info->renderer);
    put_string(j, "version", info->version);
    put_uint(j, "threads", kd_jobs_threads(jobs));
    kd_json_object_end(j);
}

/* What the caches hold on the GPU and in lists of the CPU, spare room left out. */
static uint64_t cache_bytes(const kd_voxel_scene *s)
{
    return kd_ranges_taken(&s->voxel_places) * 12 +
           kd_ranges_taken(&s->binding_places) * KD_BINDING_WORDS * sizeof(uint32_t) +
           s->chunk_count * (sizeof(kd_voxel_chunk) + sizeof(struct kd_voxel_chunk_params)) +
           s->cache_count * sizeof(kd_voxel_cache);
}

static void put_voxels(kd_json *j, kd_world *w)
{
    const kd_tree *tree = kd_singleton(w, kd_tree);
    kd_json_key(j, "voxels");
    kd_json_object_begin(j);
    put_uint(j, "cached", tree->cached_voxels);
    put_uint(j, "cached_bytes", cache_bytes(kd_singleton(w, kd_voxel_scene)));
    put_uint(j, "resident", tree->resident_voxels);
    put_uint(j, "static", tree->static_voxels);
    put_uint(j, "dynamic", tree->dynamic_voxels);
    put_uint(j, "leaves", tree->leaf_cells);
    kd_json_key(j, "cascades");
    kd_json_array_begin(j);
    for (uint32_t c = 0; c < tree->cascade_count; c++) {
        kd_json_object_begin(j);
        put_double(j, "span_m", (double)tree->span_m[c]);
        put_uint(j, "resolution", tree->resolution);
        put_uint(j, "voxels", tree->cascade_voxels[c]);
        put_uint(j, "nodes", tree->cascade_nodes[c]);
        put_uint(j, "bytes", tree->cascade_bytes[c]);
        kd_json_object_end(j);
    }
    kd_json_array_end(j);
    kd_json_object_end(j);
}

static void put_cone(kd_json *j, const uint32_t *c)
{
    kd_json_object_begin(j);
    put_uint(j, "traced", c[0]);
    put_uint(j, "samples", c[1]);
    put_double(j, "mean", c[0] ? (double)c[1] / c[0] : 0);
    put_uint(j, "max", c[2]);
    kd_json_object_end(j);
}

/* Samples of the last frame's cones, when they were counted. */
static void put_cones(kd_json *j, kd_world *w, kd_gpu *gpu)
{
    const kd_gi_targets *gi = kd_singleton(w, kd_gi_targets);
    uint32_t counts[KD_CONE_COUNTERS], diffuse = 0;
    uint64_t samples = 0, pixels = (uint64_t)gi->width * gi->height;
    if (!gi->counted)
        return;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, gi->samples, 0, counts, sizeof counts);
    for (uint32_t i = 0; i < KD_MAX_CONES + 2; i++)
        samples += counts[KD_CONE_HEAD + i * KD_CONE_WORDS + 1];
    while (diffuse < KD_MAX_CONES && counts[KD_CONE_HEAD + diffuse * KD_CONE_WORDS])
        diffuse++;
    kd_json_key(j, "cones");
    kd_json_object_begin(j);
    put_uint(j, "pixels", pixels);
    put_uint(j, "traced", counts[0]);
    put_uint(j, "samples", samples);
    put_double(j, "mean", pixels ? (double)samples / (double)pixels : 0);
    put_uint(j, "max", counts[1]);
    kd_json_key(j, "diffuse");
    kd_json_array_begin(j);
    for (uint32_t i = 0; i < diffuse; i++)
        put_cone(j, &counts[KD_CONE_HEAD + i * KD_CONE_WORDS]);
    kd_json_array_end(j);
    kd_json_key(j, "glossy");
    put_cone(j, &counts[KD_CONE_HEAD + KD_MAX_CONES * KD_CONE_WORDS]);
    kd_json_key(j, "emitters");
    put_cone(j, &counts[KD_CONE_HEAD + (KD_MAX_CONES + 1) * KD_CONE_WORDS]);
    kd_json_object_end(j);
}

/* Bytes by name of what is alive on the GPU's side, largest first. */
static void put_buffers(kd_json *j, const kd_gpu *gpu)
{
    enum { ROWS = 128 };
    kd_gpu_memory_row rows[ROWS];
    uint32_t count = kd_gpu_memory(gpu, rows, ROWS);
    kd_json_key(j, "buffers");
    kd_json_object_begin(j);
    for (uint32_t i = 0; i < count; i++)
        put_uint(j, rows[i].name, rows[i].bytes);
    kd_json_object_end(j);
}

static void put_rest(kd_json *j, const kd_gpu *gpu)
{
    struct rusage usage = {0};
    uint32_t count;
    const char *const *warnings = app_console_warnings(&count);
    getrusage(RUSAGE_SELF, &usage);
    kd_json_key(j, "memory");
    kd_json_object_begin(j);
    put_uint(j, "gpu_bytes", kd_gpu_bytes(gpu));
    put_uint(j, "cpu_peak_bytes", (uint64_t)usage.ru_maxrss * 1024);
    put_buffers(j, gpu);
    kd_json_object_end(j);
    kd_json_key(j, "warnings");
    kd_json_array_begin(j);
    for (uint32_t i = 0; i < count; i++)
        kd_json_string(j, warnings[i]);
    kd_json_array_end(j);
}

kd_status app_stats_write(const char *path, const app_scene *scene, const app_timing *timing, kd_gpu *gpu,
                          const kd_jobs *jobs, uint64_t frames)
{
    kd_json j = {.indent = 2};
    kd_json_object_begin(&j);
    put_string(&j, "kandil", KD_VERSION);
    put_scene(&j, scene->world);
    put_context(&j, gpu, jobs);
    kd_json_key(&j, "size");
    kd_json_array_begin(&j);
    kd_json_uint(&j, scene->width);
    kd_json_uint(&j, scene->height);
    kd_json_array_end(&j);
    put_uint(&j, "frames", frames);
    put_string(&j, "gi", app_gi_words[scene->gi]);
    put_string(&j, "gpu_timing", timing->mode == APP_TIMING_SYNC ? "sync" : "timestamps");
    kd_profile_write_json(timing->profile, &j);
    put_voxels(&j, scene->world);
    put_cones(&j, scene->world, gpu);
    put_rest(&j, gpu);
    kd_json_object_end(&j);
    const char *text = kd_json_text(&j);
    kd_status status =
        text ? kd_file_write(path, text, strlen(text)) : kd_fail(KD_NO_MEMORY, "%s: out of memory", path);
    kd_json_fini(&j);
    return status;
}
