/* Fills the G-buffer: every batch of the draw list that touches the view, one set of parameters and one draw
 * call each. Programs are made for the maps a material has, when the first such material is drawn. */

#include "systems/deferred/deferred.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/camera.h"
#include "components/film.h"
#include "components/frame.h"
#include "components/material.h"
#include "components/render_targets.h"
#include "runtime/core/arena.h"
#include "runtime/core/box_tree.h"
#include "runtime/core/frustum.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/film.h"
#include "systems/deferred/internal.h"

enum { MAP_VARIANTS = 32 };

typedef struct deferred_state {
    kd_gpu_program programs[MAP_VARIANTS]
                           [8];  /* by KD_MAP_* bits; bit 0: masked, 1: layered, 2: with motion */
    bool tried[MAP_VARIANTS][8]; /* a program that failed is not compiled again every frame */
    bool layered;                /* since a material with lobes has been drawn */
    kd_gpu_buffer args;
    uint64_t drawn_triangles;
} deferred_state;

static kd_gpu_texture make_texture(kd_gpu *gpu, kd_texture_format format, const kd_frame *frame,
                                   const char *name)
{
    return kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = format,
                                                           .width = frame->width,
                                                           .height = frame->height,
                                                           .filter = KD_NEAREST,
                                                           .name = name});
}

static void destroy_gbuffer(kd_gpu *gpu, kd_gbuffer *g)
{
    kd_gpu_destroy_target(gpu, g->target);
    kd_gpu_destroy_texture(gpu, g->albedo);
    kd_gpu_destroy_texture(gpu, g->normal);
    kd_gpu_destroy_texture(gpu, g->material);
    kd_gpu_destroy_texture(gpu, g->emissive);
    kd_gpu_destroy_texture(gpu, g->depth);
    kd_gpu_destroy_texture(gpu, g->layers);
    kd_gpu_destroy_texture(gpu, g->motion);
    *g = (kd_gbuffer){0};
}

/* The formats are those that shaders/include/surface.glsl packs. */
static void ensure_gbuffer(kd_gpu *gpu, kd_gbuffer *g, const kd_frame *frame, bool layered, bool motion)
{
    if (g->width == frame->width && g->height == frame->height && layered == (g->layers.id != 0) &&
        motion == (g->motion.id != 0))
        return;
    destroy_gbuffer(gpu, g);
    g->albedo = make_texture(gpu, KD_RGBA8, frame, "gbuffer albedo");
    g->normal = make_texture(gpu, KD_RGBA16UI, frame, "gbuffer normal");
    g->material = make_texture(gpu, KD_RGBA8, frame, "gbuffer material");
    g->emissive = make_texture(gpu, KD_RGBA16F, frame, "gbuffer emissive");
    g->depth = make_texture(gpu, KD_DEPTH32F, frame, "gbuffer depth");
    if (layered)
        g->layers = make_texture(gpu, KD_RGBA16UI, frame, "gbuffer layers");
    if (motion)
        g->motion = make_texture(gpu, KD_RG16F, frame, "gbuffer motion");
    g->target =
        kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.color = {g->albedo, g->normal, g->material,
                                                                g->emissive, layered ? g->layers : g->motion,
                                                                layered ? g->motion : (kd_gpu_texture){0}},
                                                      .depth = g->depth,
                                                      .name = "gbuffer"});
    g->width = frame->width;
    g->height = frame->height;
}

/* Blended ones come last in the list and are drawn elsewhere. */
static bool draws_lobes(const kd_draw_list *list, const kd_scene_store *store)
{
    for (uint32_t b = 0; b < list->batch_count && !deferred_is_blended(store, &list->batches[b]); b++)
        if (kd_material_has_lobes(&store->materials[list->batches[b].material].desc))
            return true;
    return false;
}

static kd_gpu_program find_program(kd_gpu *gpu, deferred_state *s, uint32_t maps, bool masked, bool motion)
{
    uint32_t kind = (masked ? 1u : 0u) | (s->layered ? 2u : 0u) | (motion ? 4u : 0u);
    if (!s->tried[maps][kind]) {
        char define[32];
        snprintf(define, sizeof define, "MATERIAL_MAPS %u", maps);
        const char *defines[6] = {define};
        int count = 1;
        if (masked)
            defines[count++] = "MASKED";
        if (s->layered)
            defines[count++] = "LAYERED";
        if (motion)
            defines[count++] = "MOTION";
        if (kd_gpu_get_info(gpu)->software && (maps & KD_MAP_BASE_COLOR))
            defines[count] = "KD_TAPS 4";
        s->programs[maps][kind] =
            kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.vertex = "shaders/deferred/geometry.vert",
                                                            .fragment = "shaders/deferred/geometry.frag",
                                                            .defines = defines});
        s->tried[maps][kind] = true;
    }
    return s->programs[maps][kind];
}

/* Gather the arguments of the draws that touch the view, and how many of each batch; blended ones come last
 * and are left out. Returns how many. */
static uint32_t cull_draws(const kd_draw_list *list, const kd_scene_store *store, const kd_frustum *frustum,
                           uint32_t *numbers, kd_draw_indexed *args, uint32_t *counts)
{
    uint32_t count = kd_box_tree_in_frustum(list->tree, frustum, numbers), b = 0, i = 0;
    memset(counts, 0, list->batch_count * sizeof *counts);
    for (; i < count; i++) {
        while (numbers[i] >= list->batches[b].first_draw + list->batches[b].draw_count)
            b++;
        if (deferred_is_blended(store, &list->batches[b]))
            break;
        args[i] = list->draws[numbers[i]].args;
        counts[b]++;
    }
    return i;
}

/* Bind parameters and maps. Returns the program that reads them. */
static kd_gpu_program bind_material(kd_gpu *gpu, deferred_state *s, const kd_store_material *material,
                                    bool motion)
{
    kd_material_bind(gpu, material);
    return find_program(gpu, s, deferred_map_bits(material), material->desc.alpha_mode == KD_ALPHA_MASK,
                        motion);
}

/* Bind what was where a frame ago. Returns the vertices with their former places. */
static kd_gpu_geometry bind_motion(kd_system_context *context, const kd_gbuffer *g)
{
    const kd_motion *motion = kd_singleton(context->world, kd_motion);
    struct kd_motion_params params = {.size = {.x = (float)g->width, .y = (float)g->height}};
    memcpy(params.view_projection.m, motion->view_projection.m, sizeof params.view_projection.m);
    kd_gpu_bind_uniform(context->gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_storage(context->gpu, 1, motion->models);
    return deferred_moving_geometry(kd_singleton(context->world, kd_scene_store),
                                    kd_singleton(context->world, kd_draw_list), motion->geometry);
}

/* Culling is part of a target's state; a change of it binds the target again, without clearing. */
static void begin_raster(kd_gpu *gpu, const kd_gbuffer *g, kd_cull cull, bool clear)
{
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = g->target,
                                              .width = g->width,
                                              .height = g->height,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .cull = cull,
                                              .clear_depth = clear});
}

static void draw_batches(kd_system_context *context, deferred_state *s, const kd_gbuffer *g,
                         const kd_draw_indexed *args, const uint32_t *counts)
{
    kd_gpu *gpu = context->gpu;
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    bool motion = g->motion.id != 0;
    kd_gpu_geometry geometry = motion ? bind_motion(context, g) : deferred_geometry(store, list);
    kd_cull cull = KD_CULL_BACK;
    kd_gpu_bind_storage(gpu, 0, list->objects);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, kd_singleton(context->world, kd_lighting)->view, 0,
                               sizeof(struct kd_view_params));
    for (uint32_t b = 0, first = 0; b < list->batch_count; first += counts[b++]) {
        if (counts[b] == 0)
            continue;
        const kd_store_material *material = &store->materials[list->batches[b].material];
        kd_cull wanted = deferred_cull(&list->batches[b], material);
        if (wanted != cull)
            begin_raster(gpu, g, cull = wanted, false);
        kd_gpu_program program = bind_material(gpu, s, material, motion);
        kd_gpu_draw_indirect(gpu, program, &geometry, s->args, first * sizeof *args, counts[b]);
        for (uint32_t i = first; i < first + counts[b]; i++)
            s->drawn_triangles += args[i].index_count / 3;
    }
}

static void geometry_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    deferred_state *s = context->user;
    kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    s->layered = s->layered || draws_lobes(list, store);
    ensure_gbuffer(gpu, g, kd_singleton(context->world, kd_frame), s->layered,
                   kd_singleton(context->world, kd_film)->layers);
    begin_raster(gpu, g, KD_CULL_BACK, true);
    s->drawn_triangles = 0;
    if (list->draw_count == 0)
        return;
    kd_frustum frustum = kd_frustum_make(&kd_singleton(context->world, kd_view)->view_projection, -1);
    kd_draw_indexed *args = KD_ARENA_NEW(context->scratch, kd_draw_indexed, list->draw_count);
    uint32_t *counts = KD_ARENA_NEW(context->scratch, uint32_t, list->batch_count);
    uint32_t *numbers = KD_ARENA_NEW(context->scratch, uint32_t, 2 * (size_t)list->draw_count);
    if (args == NULL || counts == NULL || numbers == NULL) {
        kd_fail(KD_NO_MEMORY, "geometry: no memory for %u draws; use a smaller scene", list->draw_count);
        return;
    }
    uint32_t total = cull_draws(list, store, &frustum, numbers, args, counts);
    if (total == 0)
        return;
    kd_gpu_ensure_buffer(gpu, &s->args, total * sizeof *args, 0, "geometry arguments");
    kd_gpu_write_buffer(gpu, s->args, 0, args, total * sizeof *args);
    draw_batches(context, s, g, args, counts);
}

static void geometry_fini(kd_system_context *context)
{
    deferred_state *s = context->user;
    destroy_gbuffer(context->gpu, kd_singleton(context->world, kd_gbuffer));
    const kd_gpu_program *programs = &s->programs[0][0];
    for (size_t i = 0; i < sizeof s->programs / sizeof *programs; i++)
        kd_gpu_destroy_program(context->gpu, programs[i]);
    kd_gpu_destroy_buffer(context->gpu, s->args);
    free(s);
}

/* What the targets and the triangles' vertices weigh: texels are written once at least. */
static uint64_t geometry_bytes(const kd_system_context *context)
{
    const kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    const deferred_state *s = context->user;
    enum { TEXEL_BYTES = 4 + 8 + 4 + 8 + 4 };
    return (uint64_t)g->width * g->height * TEXEL_BYTES +
           s->drawn_triangles * 3 * (DEFERRED_GEOMETRY_STRIDE + DEFERRED_ATTRIBUTE_STRIDE + 4);
}

kd_status kd_deferred_import(kd_schedule *schedule)
{
    deferred_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return kd_fail(KD_NO_MEMORY, "geometry: no memory for its state; free some");
    kd_status status = kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "geometry",
                          .phase = KD_PHASE_GEOMETRY,
                          .where = KD_ON_GPU,
                          .components = {KD_USES(kd_draw_list), KD_USES(kd_scene_store), KD_USES(kd_view),
                                         KD_USES(kd_frame), KD_USES(kd_lighting), KD_USES(kd_film),
                                         KD_USES(kd_motion), KD_CHANGES(kd_gbuffer)},
                          .resources = {{"motion", KD_USE_VERTEX | KD_USE_STORAGE_READ},
                                        {"scene.vertices", KD_USE_VERTEX},
                                        {"scene.indices", KD_USE_INDEX},
                                        {"scene.objects", KD_USE_STORAGE_READ | KD_USE_VERTEX},
                                        {"lights.uniform", KD_USE_UNIFORM},
                                        {"gbuffer", KD_USE_TARGET}},
                          .no_commands = true,
                          .run = geometry_run,
                          .fini = geometry_fini,
                          .bytes_moved = geometry_bytes,
                          .user = s});
    if (status != KD_OK)
        free(s);
    return status;
}
