/* System view_voxels: `--view caches` draws the voxels of the models at their objects, `--view pages` those
 * that the pages hold in the world. What is drawn is a number a pixel; a last pass shows what belongs to it.
 */
#include <stdlib.h>

#include "components/pose_access.h"
#include "components/tree_access.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "runtime/gpu/work_list.h"
#include "shaders/shared/bindings.h"
#include "systems/debug_view/internal.h"

/* Voxels that cover many pixels: what the shader lists at most. */
#define LARGE_MOST 65535u

typedef enum voxel_source { CACHES, STATIC_PAGES, DYNAMIC_PAGES, SOURCE_COUNT } voxel_source;

typedef struct voxel_view {
    kd_gpu_program draw[SOURCE_COUNT];
    kd_tree_program show[SOURCE_COUNT];
    kd_gpu_buffer pixels, large;
    kd_gpu_buffer segments; /* of the caches shown */
    struct kd_voxel_segment *listed;
    uint32_t listed_count, listed_capacity;
    kd_pose_access pose;
    kd_texel_view shape_view, color_view;
} voxel_view;

static const char *const draw_paths[SOURCE_COUNT] = {"shaders/debug_view/draw_caches.comp",
                                                     "shaders/debug_view/draw_pages_static.comp",
                                                     "shaders/debug_view/draw_pages_dynamic.comp"};
static const char *const show_paths[SOURCE_COUNT] = {"shaders/debug_view/show_caches.comp",
                                                     "shaders/debug_view/show_pages_static.comp",
                                                     "shaders/debug_view/show_pages_dynamic.comp"};

/* ---- which caches are shown ---- */

/* The cache of the level, or the finest above it that there is; KD_MAX_CASCADES: none. */
static uint32_t shown_cascade(const kd_voxel_scene *scene, const kd_voxel_object *o, int32_t level)
{
    uint32_t last = scene->cascade_count - 1, c = level < 0 ? 0 : (uint32_t)level;
    for (c = c < last ? c : last; c <= last; c++)
        if (o->caches[c] && scene->caches[o->caches[c] - 1].made)
            return c;
    return KD_MAX_CASCADES;
}

static kd_status list_segment(voxel_view *v, struct kd_voxel_segment segment)
{
    if (v->listed_count == v->listed_capacity) {
        uint32_t capacity = v->listed_capacity ? v->listed_capacity * 2 : 256;
        struct kd_voxel_segment *grown = realloc(v->listed, capacity * sizeof *grown);
        if (!grown)
            return KD_NO_MEMORY;
        v->listed = grown;
        v->listed_capacity = capacity;
    }
    v->listed[v->listed_count++] = segment;
    return KD_OK;
}

static kd_status list_object(voxel_view *v, const kd_voxel_scene *scene, uint32_t object, uint32_t c)
{
    const kd_voxel_cache *cache = &scene->caches[scene->objects[object].caches[c] - 1];
    kd_status status = KD_OK;
    for (uint32_t k = cache->first_chunk; k < cache->first_chunk + cache->chunk_count; k++) {
        const kd_voxel_chunk *chunk = &scene->chunks[k];
        for (uint32_t at = 0; at < chunk->count && !status; at += KD_SEGMENT_VOXELS) {
            uint32_t left = chunk->count - at, count = left < KD_SEGMENT_VOXELS ? left : KD_SEGMENT_VOXELS;
            status =
                list_segment(v, (struct kd_voxel_segment){object, chunk->first + at, count, k | c << 28});
        }
    }
    return status;
}

static kd_status list_caches(kd_gpu *gpu, voxel_view *v, const kd_voxel_scene *scene, int32_t level)
{
    kd_status status = KD_OK;
    v->listed_count = 0;
    for (uint32_t i = 0; i < scene->object_count && !status; i++) {
        const kd_voxel_object *o = &scene->objects[i];
        uint32_t c = o->alive && o->seen ? shown_cascade(scene, o, level) : KD_MAX_CASCADES;
        if (c < KD_MAX_CASCADES)
            status = list_object(v, scene, i, c);
    }
    size_t size = v->listed_count * sizeof *v->listed;
    if (!status && size)
        status = kd_gpu_ensure_buffer(gpu, &v->segments, size, 0, "view.segments");
    if (!status && size)
        kd_gpu_write_buffer(gpu, v->segments, 0, v->listed, size);
    return status;
}

/* ---- drawing ---- */

static void bind_source(kd_system_context *context, voxel_view *v, voxel_source source)
{
    const kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_gpu *gpu = context->gpu;
    kd_texel_view_bind(gpu, &v->shape_view, 4, scene->cache_shape, KD_RG32UI);
    kd_texel_view_bind(gpu, &v->color_view, 5, scene->cache_color, KD_R32UI);
    if (source == CACHES) {
        kd_gpu_bind_storage(gpu, 0, v->segments);
        kd_gpu_bind_storage(gpu, 1, scene->object_params);
        kd_gpu_bind_storage(gpu, 2, scene->chunk_params);
        kd_pose_access_bind(gpu, &v->pose, kd_singleton(context->world, kd_scene_store),
                            kd_singleton(context->world, kd_joint_palette), scene->cache_binding);
    } else if (source == STATIC_PAGES) {
        kd_gpu_bind_storage(gpu, 1, scene->pages[KD_LAYER_STATIC].segments);
        kd_gpu_bind_storage(gpu, 2, scene->object_params);
        kd_gpu_bind_storage(gpu, 3, scene->chunk_params);
    } else {
        kd_gpu_bind_storage(gpu, 1, scene->pages[KD_LAYER_DYNAMIC].segments);
        kd_gpu_bind_storage(gpu, 2, scene->pages[KD_LAYER_DYNAMIC].voxels);
    }
    kd_gpu_bind_storage(gpu, 5, v->pixels);
    kd_gpu_bind_storage(gpu, 6, v->large);
}

typedef struct voxel_pass {
    struct kd_debug_view_params view;
    struct kd_voxel_view_params voxels;
} voxel_pass;

static uint32_t slots_of(const kd_voxel_scene *scene, const voxel_view *v, voxel_source source)
{
    if (source == CACHES)
        return v->listed_count;
    const kd_voxel_pages *pages = &scene->pages[source == STATIC_PAGES ? KD_LAYER_STATIC : KD_LAYER_DYNAMIC];
    return pages->segment_count ? pages->page_count * KD_PAGE_SEGMENTS : 0;
}

/* Dispatch what is small, then what was listed. */
static void draw_source(kd_gpu *gpu, const voxel_view *v, voxel_pass *pass, voxel_source source, bool numbers)
{
    pass->voxels.source.z = numbers;
    pass->voxels.source.w = 0;
    kd_gpu_clear_work_list(gpu, v->large);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, pass, sizeof *pass);
    kd_gpu_dispatch_linear(gpu, v->draw[source], pass->voxels.source.y * (KD_SEGMENT_VOXELS / 64));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
    pass->voxels.source.w = 1;
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, pass, sizeof *pass);
    kd_gpu_dispatch_indirect(gpu, v->draw[source], v->large, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

static kd_status fit(kd_gpu *gpu, voxel_view *v, const kd_tree *tree, size_t pixels, voxel_source first,
                     voxel_source last)
{
    kd_status status = kd_gpu_ensure_buffer(gpu, &v->pixels, pixels * 8, 0, "view.pixels");
    if (!status)
        status = kd_gpu_fit_work_list(gpu, &v->large, LARGE_MOST, "view.large");
    for (voxel_source s = first; s <= last && !status; s++) {
        if (!v->draw[s].id)
            v->draw[s] = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = draw_paths[s]});
        if (!v->draw[s].id || !kd_tree_fit_program(gpu, tree, show_paths[s], &v->show[s]))
            status = KD_GPU;
    }
    return status;
}

/* Depths of all sources first, then the numbers of what is nearest. */
static void draw_all(kd_system_context *context, voxel_view *v, voxel_pass *pass, voxel_source first,
                     voxel_source last)
{
    const kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_gpu *gpu = context->gpu;
    for (int numbers = 0; numbers < 2; numbers++)
        for (voxel_source s = first; s <= last; s++) {
            pass->voxels.source.x = s == DYNAMIC_PAGES ? KD_VIEW_DYNAMIC : 0;
            pass->voxels.source.y = slots_of(scene, v, s);
            if (!pass->voxels.source.y)
                continue;
            bind_source(context, v, s);
            draw_source(gpu, v, pass, s, numbers);
        }
}

static void show_all(kd_system_context *context, voxel_view *v, voxel_pass *pass, voxel_source first,
                     voxel_source last)
{
    const kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_tree_bind(context->gpu, kd_singleton(context->world, kd_tree));
    for (voxel_source s = first; s <= last; s++) {
        pass->voxels.source.x = s == DYNAMIC_PAGES ? KD_VIEW_DYNAMIC : 0;
        pass->voxels.source.y = slots_of(scene, v, s);
        if (!pass->voxels.source.y)
            continue;
        kd_gpu_bind_uniform(context->gpu, KD_BIND_PASS, pass, sizeof *pass);
        bind_source(context, v, s);
        debug_view_dispatch(context, v->show[s].program);
    }
}

static void run(kd_system_context *context)
{
    voxel_view *v = context->user;
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    const kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    bool caches = frame->view == KD_VIEW_CACHES;
    voxel_source first = caches ? CACHES : STATIC_PAGES, last = caches ? CACHES : DYNAMIC_PAGES;
    debug_view_begin(context);
    if (!tree->radiance.id)
        return;
    kd_status status = fit(gpu, v, tree, (size_t)frame->width * frame->height, first, last);
    if (!status && caches)
        status = list_caches(gpu, v, scene, frame->settings.view_level);
    if (status) {
        kd_log(KD_LOG_WARNING, "view of voxels: %s; show a coarser level", kd_status_text(status));
        return;
    }
    voxel_pass pass = {.view = debug_view_params(frame, svo)};
    kd_gpu_fill_buffer(gpu, v->pixels, 0, kd_gpu_buffer_size(gpu, v->pixels), UINT32_MAX);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, tree->uniform, 0, sizeof(struct kd_tree_params));
    draw_all(context, v, &pass, first, last);
    show_all(context, v, &pass, first, last);
}

static bool asked_for(kd_system_context *context)
{
    uint32_t view = kd_singleton(context->world, kd_frame)->view;
    return view == KD_VIEW_CACHES || view == KD_VIEW_PAGES;
}

static kd_status init(kd_system_context *context)
{
    voxel_view *v = context->user;
    return kd_pose_access_init(context->gpu, &v->pose);
}

static void fini(kd_system_context *context)
{
    voxel_view *v = context->user;
    kd_gpu *gpu = context->gpu;
    for (voxel_source s = 0; s < SOURCE_COUNT; s++) {
        kd_gpu_destroy_program(gpu, v->draw[s]);
        kd_gpu_destroy_program(gpu, v->show[s].program);
    }
    kd_gpu_destroy_buffer(gpu, v->pixels);
    kd_gpu_destroy_buffer(gpu, v->large);
    kd_gpu_destroy_buffer(gpu, v->segments);
    kd_pose_access_fini(gpu, &v->pose);
    kd_texel_view_fini(gpu, &v->shape_view);
    kd_texel_view_fini(gpu, &v->color_view);
    free(v->listed);
    free(v);
}

kd_status debug_view_add_voxels(kd_schedule *s)
{
    voxel_view *v = calloc(1, sizeof *v);
    if (!v)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "view_voxels",
                                  .phase = KD_PHASE_VIEW,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_voxel_scene), KD_USES(kd_tree), KD_USES(kd_svo),
                                                 KD_USES(kd_lighting), KD_USES(kd_frame), KD_USES(kd_picture),
                                                 KD_USES(kd_scene_store), KD_USES(kd_joint_palette)},
                                  .resources = {{"voxels.pages", KD_USE_STORAGE_READ},
                                                {"voxels.objects", KD_USE_STORAGE_READ},
                                                {"voxels.chunks", KD_USE_STORAGE_READ},
                                                {"voxels.cache", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                                                {"scene.vertices", KD_USE_SAMPLED},
                                                {"scene.indices", KD_USE_SAMPLED},
                                                {"scene.joints", KD_USE_SAMPLED},
                                                {"tree.uniform", KD_USE_UNIFORM},
                                                {"tree.radiance", KD_USE_SAMPLED},
                                                {"tree.nodes", KD_USE_SAMPLED},
                                                {"tree.leaves", KD_USE_SAMPLED},
                                                {"tree.data", KD_USE_SAMPLED},
                                                {"lights.uniform", KD_USE_UNIFORM},
                                                {"picture", KD_USE_IMAGE_WRITE | KD_USE_COPY_WRITE}},
                                  .run_if = asked_for,
                                  .no_commands = true,
                                  .run = run,
                                  .init = init,
                                  .fini = fini,
                                  .user = v,
                              });
}
