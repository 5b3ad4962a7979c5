/* System blend: surfaces that let through what is behind them. They are drawn one by one, the farthest first,
 * over each other into a texture of their own, hidden by what the G-buffer holds; resolve lays it over the
 * picture. Each pixel is lit by itself, from lights and octree. Of a double-sided surface the backs come
 * before the fronts. Objects that pierce each other are not told apart. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "components/camera.h"
#include "components/emitters.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "components/sky.h"
#include "components/tree_access.h"
#include "runtime/core/arena.h"
#include "runtime/core/frustum.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/blend.h"
#include "shaders/shared/resolve.h"
#include "systems/deferred/deferred.h"
#include "systems/deferred/internal.h"

enum { BLEND_TINTED = 4, BLEND_LAYERED = 8 };

/* A program for the maps of a material, the view, the kinds of light and the depth of the octree. */
typedef struct blend_variant {
    uint32_t maps, show, sparse_levels; /* sparse_levels 0: no light is gathered */
    bool strict;                        /* KD_LEAK_STRICT */
    uint32_t kinds;                     /* bits: directional lights, local lights, tinted, layered */
    kd_gpu_program program;
} blend_variant;

typedef struct blend_state {
    blend_variant *variants;
    uint32_t variant_count;
    kd_gpu_texture texture, hidden; /* hidden: shares by colour, where some surface tints */
    kd_gpu_target target;
    kd_gpu_texture depth; /* the G-buffer's, which the target holds too */
    uint32_t width, height;
} blend_state;

/* One draw, by what orders it. */
typedef struct blend_item {
    float distance; /* of the middle of its box along the view */
    uint32_t draw;  /* of the draw list */
    const kd_draw_batch *batch;
} blend_item;

/* ---- targets ---- */

static void destroy_target(kd_gpu *gpu, blend_state *s)
{
    kd_gpu_destroy_target(gpu, s->target);
    kd_gpu_destroy_texture(gpu, s->texture);
    kd_gpu_destroy_texture(gpu, s->hidden);
    s->target = (kd_gpu_target){0};
    s->texture = s->hidden = (kd_gpu_texture){0};
}

static kd_gpu_texture make_texture(kd_gpu *gpu, const kd_gbuffer *g, const char *name)
{
    return kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_RGBA16F,
                                                           .width = g->width,
                                                           .height = g->height,
                                                           .filter = KD_NEAREST,
                                                           .name = name});
}

static void ensure_target(kd_gpu *gpu, blend_state *s, const kd_gbuffer *g, bool tinted)
{
    if (s->texture.id != 0 && s->depth.id == g->depth.id && s->width == g->width && s->height == g->height &&
        tinted == (s->hidden.id != 0))
        return;
    destroy_target(gpu, s);
    s->texture = make_texture(gpu, g, "blended");
    if (tinted)
        s->hidden = make_texture(gpu, g, "blended hidden");
    s->target = kd_gpu_make_target(
        gpu, &(kd_gpu_target_desc){.color = {s->texture, s->hidden}, .depth = g->depth, .name = "blended"});
    s->depth = g->depth;
    s->width = g->width;
    s->height = g->height;
}

/* ---- order ---- */

/* What is equally far is told apart by where it is, not by when it was made. */
static int compare_items(const kd_draw_list *list, const blend_item *a, const blend_item *b)
{
    if (a->distance != b->distance)
        return a->distance > b->distance ? -1 : 1;
    const kd_draw *p = &list->draws[a->draw], *q = &list->draws[b->draw];
    const float x[6] = {p->bounds_min_ws.x, p->bounds_min_ws.y, p->bounds_min_ws.z,
                        p->bounds_max_ws.x, p->bounds_max_ws.y, p->bounds_max_ws.z},
                y[6] = {q->bounds_min_ws.x, q->bounds_min_ws.y, q->bounds_min_ws.z,
                        q->bounds_max_ws.x, q->bounds_max_ws.y, q->bounds_max_ws.z};
    for (int i = 0; i < 6; i++)
        if (x[i] != y[i])
            return x[i] < y[i] ? -1 : 1;
    return a->draw < b->draw ? -1 : 1;
}

/* There are few, and the last frame's order is no help: lists are sorted by material. */
static void sort_items(const kd_draw_list *list, blend_item *items, uint32_t count)
{
    for (uint32_t gap = count / 2; gap > 0; gap /= 2)
        for (uint32_t i = gap; i < count; i++) {
            blend_item item = items[i];
            uint32_t j = i;
            for (; j >= gap && compare_items(list, &item, &items[j - gap]) < 0; j -= gap)
                items[j] = items[j - gap];
            items[j] = item;
        }
}

static float distance_of(const kd_draw *draw, const kd_view *view)
{
    kd_vec3 middle = kd_vec3_scale(kd_vec3_add(draw->bounds_min_ws, draw->bounds_max_ws), 0.5f);
    return kd_vec3_dot(kd_vec3_sub(middle, view->position_ws), view->forward_ws);
}

static uint32_t collect(kd_system_context *context, blend_item *items)
{
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    const kd_view *view = kd_singleton(context->world, kd_view);
    kd_frustum frustum = kd_frustum_make(&view->view_projection, -1);
    uint32_t count = 0;
    for (uint32_t b = 0; b < list->batch_count; b++) {
        const kd_draw_batch *batch = &list->batches[b];
        if (!deferred_is_blended(store, batch))
            continue;
        for (uint32_t i = batch->first_draw; i < batch->first_draw + batch->draw_count; i++)
            if (kd_frustum_touches(&frustum, list->draws[i].bounds_min_ws, list->draws[i].bounds_max_ws))
                items[count++] = (blend_item){distance_of(&list->draws[i], view), i, batch};
    }
    return count;
}

static bool tints(const kd_scene_store *store, const blend_item *items, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (store->materials[items[i].batch->material].desc.transmission > 0)
            return true;
    return false;
}

/* ---- drawing ---- */

static kd_gpu_program make_program(kd_gpu *gpu, const blend_variant *v)
{
    char maps[32], show[16], levels[32];
    const char *defines[9] = {maps, show};
    int count = 2;
    snprintf(maps, sizeof maps, "MATERIAL_MAPS %u", v->maps);
    snprintf(show, sizeof show, "SHOW %uu", v->show);
    snprintf(levels, sizeof levels, "KD_SPARSE_LEVELS %u", v->sparse_levels);
    if (v->kinds & 1)
        defines[count++] = "DIRECTIONAL";
    if (v->kinds & 2)
        defines[count++] = "LOCAL";
    if (v->kinds & BLEND_TINTED)
        defines[count++] = "TINTED";
    if (v->kinds & BLEND_LAYERED)
        defines[count++] = "LAYERED";
    if (v->sparse_levels > 0)
        defines[count++] = levels;
    if (v->strict)
        defines[count] = "KD_LEAK_STRICT 1";
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.vertex = "shaders/deferred/geometry.vert",
                                                           .fragment = "shaders/deferred/blend.frag",
                                                           .defines = defines});
}

/* A program that failed is kept too, so that it is not compiled again every frame. */
static kd_gpu_program find_program(kd_gpu *gpu, blend_state *s, blend_variant wanted)
{
    for (uint32_t i = 0; i < s->variant_count; i++) {
        const blend_variant *v = &s->variants[i];
        if (v->maps == wanted.maps && v->show == wanted.show && v->kinds == wanted.kinds &&
            v->sparse_levels == wanted.sparse_levels && v->strict == wanted.strict)
            return v->program;
    }
    blend_variant *grown = realloc(s->variants, (s->variant_count + 1) * sizeof *grown);
    if (grown == NULL)
        return (kd_gpu_program){0};
    wanted.program = make_program(gpu, &wanted);
    s->variants = grown;
    s->variants[s->variant_count++] = wanted;
    return wanted.program;
}

/* What the frame asks of all programs. */
static blend_variant frame_variant(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    bool gathers = kd_frame_needs_voxels(context) && tree->radiance.id != 0;
    return (blend_variant){.show = frame->view < KD_SHOW_COUNT ? frame->view : KD_SHOW_FINAL,
                           .kinds = (lighting->directional_count > 0 ? 1u : 0u) |
                                    (lighting->light_count > lighting->directional_count ? 2u : 0u),
                           .sparse_levels = gathers ? kd_tree_sparse_levels(tree) : 0,
                           .strict = gathers && tree->strict};
}

static void bind_scene(kd_system_context *context, bool gathers)
{
    kd_gpu *gpu = context->gpu;
    const kd_settings *s = &kd_singleton(context->world, kd_frame)->settings;
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    kd_gpu_bind_storage(gpu, 0, kd_singleton(context->world, kd_draw_list)->objects);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_LIGHTS, lighting->lights, 0, sizeof(struct kd_lights_params));
    kd_gpu_bind_texture(gpu, KD_UNIT_SHADOW_DIRECTIONAL, lighting->shadow_directional);
    kd_gpu_bind_texture(gpu, KD_UNIT_SHADOW_SPOT, lighting->shadow_spot);
    kd_sky_bind(gpu, kd_singleton(context->world, kd_sky_light));
    if (!gathers)
        return;
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    struct kd_blend_params params = {.cone = {tanf(s->cones_aperture_deg * (3.14159265f / 360)),
                                              s->cones_step, kd_tree_cone_length(tree, s), s->cones_start},
                                     .light = {s->cones_intensity, s->ao_falloff, s->ao_intensity, 1}};
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_tree_bind(gpu, tree);
    kd_emitters_bind(gpu, kd_singleton(context->world, kd_emitters));
}

static void draw_faces(kd_gpu *gpu, const blend_state *s, kd_gpu_program program,
                       const kd_gpu_geometry *geometry, const kd_draw *draw, kd_cull cull)
{
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = s->target,
                                              .width = s->width,
                                              .height = s->height,
                                              .depth_test = true,
                                              .cull = cull,
                                              .blend = s->hidden.id != 0 ? KD_BLEND_TINT : KD_BLEND_ALPHA});
    kd_gpu_draw_indexed(gpu, program, geometry, &draw->args);
}

static void draw_items(kd_system_context *context, blend_state *s, const blend_item *items, uint32_t count)
{
    kd_gpu *gpu = context->gpu;
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    kd_gpu_geometry geometry = deferred_geometry(store, list);
    blend_variant variant = frame_variant(context);
    const uint32_t kinds = variant.kinds | (s->hidden.id != 0 ? BLEND_TINTED : 0u);
    bind_scene(context, variant.sparse_levels > 0);
    for (uint32_t i = 0; i < count; i++) {
        const kd_store_material *material = &store->materials[items[i].batch->material];
        const kd_draw *draw = &list->draws[items[i].draw];
        variant.maps = deferred_map_bits(material);
        variant.kinds = kinds | (kd_material_has_lobes(&material->desc) ? BLEND_LAYERED : 0u);
        kd_gpu_program program = find_program(gpu, s, variant);
        kd_material_bind(gpu, material);
        kd_cull cull = deferred_cull(items[i].batch, material);
        if (cull == KD_CULL_NONE) {
            bool mirrored = items[i].batch->mirrored;
            draw_faces(gpu, s, program, &geometry, draw, mirrored ? KD_CULL_BACK : KD_CULL_FRONT);
            cull = mirrored ? KD_CULL_FRONT : KD_CULL_BACK;
        }
        draw_faces(gpu, s, program, &geometry, draw, cull);
    }
}

static void blend_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    blend_state *s = context->user;
    kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    g->blended = g->blended_hidden = (kd_gpu_texture){0};
    if (kd_frame_shows_voxels(kd_singleton(context->world, kd_frame)))
        return;
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    if (list->batch_count == 0 || !deferred_is_blended(store, &list->batches[list->batch_count - 1]))
        return;
    blend_item *items = KD_ARENA_NEW(context->scratch, blend_item, list->draw_count);
    if (items == NULL) {
        kd_fail(KD_NO_MEMORY, "blend: no memory for %u draws; use a smaller scene", list->draw_count);
        return;
    }
    uint32_t count = collect(context, items);
    if (count == 0)
        return;
    sort_items(list, items, count);
    ensure_target(gpu, s, g, tints(store, items, count));
    kd_gpu_begin_raster(
        gpu,
        &(kd_gpu_raster){.target = s->target, .width = s->width, .height = s->height, .clear_color = true});
    draw_items(context, s, items, count);
    g->blended = s->texture;
    g->blended_hidden = s->hidden;
}

static void blend_fini(kd_system_context *context)
{
    blend_state *s = context->user;
    kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    g->blended = g->blended_hidden = (kd_gpu_texture){0};
    destroy_target(context->gpu, s);
    for (uint32_t i = 0; i < s->variant_count; i++)
        kd_gpu_destroy_program(context->gpu, s->variants[i].program);
    free(s->variants);
    free(s);
}

kd_status kd_blend_import(kd_schedule *schedule)
{
    blend_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return kd_fail(KD_NO_MEMORY, "blend: no memory for its state; free some");
    kd_status status = kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "blend",
                          .phase = KD_PHASE_GATHER,
                          .where = KD_ON_GPU,
                          .components = {KD_USES(kd_draw_list), KD_USES(kd_scene_store), KD_USES(kd_view),
                                         KD_USES(kd_frame), KD_USES(kd_lighting), KD_USES(kd_tree),
                                         KD_USES(kd_sky_light), KD_USES(kd_emitters), KD_CHANGES(kd_gbuffer)},
                          .resources = {{"scene.vertices", KD_USE_VERTEX},
                                        {"scene.indices", KD_USE_INDEX},
                                        {"scene.objects", KD_USE_STORAGE_READ | KD_USE_VERTEX},
                                        {"lights.uniform", KD_USE_UNIFORM},
                                        {"shadow.maps", KD_USE_SAMPLED},
                                        {"sky", KD_USE_UNIFORM | KD_USE_SAMPLED},
                                        {"emitters", KD_USE_UNIFORM},
                                        {"tree.uniform", KD_USE_UNIFORM},
                                        {"tree.radiance", KD_USE_SAMPLED},
                                        {"tree.nodes", KD_USE_SAMPLED},
                                        {"tree.leaves", KD_USE_SAMPLED},
                                        {"tree.data", KD_USE_SAMPLED},
                                        {"gbuffer", KD_USE_SAMPLED},
                                        {"blended", KD_USE_TARGET}},
                          .no_commands = true,
                          .run = blend_run,
                          .fini = blend_fini,
                          .user = s});
    if (status != KD_OK)
        free(s);
    return status;
}
