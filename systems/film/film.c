/* Systems film and film_layers: a frame of a film as the mean of n x n pixels and of several moments, in
 * linear light, and the parts that it is made of. Neither runs unless kd_film asks for it. */

#include "systems/film/film.h"

#include <stdlib.h>
#include <string.h>

#include "components/camera.h"
#include "components/film.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "components/surface_access.h"
#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/film.h"
#include "shaders/shared/scene.h"

enum { FILM_GROUP = 8 };

typedef struct film_state {
    kd_gpu_program mean;
    kd_gpu_program layers[KD_SURFACE_KINDS];
    bool tried[KD_SURFACE_KINDS]; /* a program that failed is not compiled again every frame */
    kd_gpu_texture black;
} film_state;

/* ---- the mean ---- */

static bool film_needed(kd_system_context *context)
{
    return kd_film_on(kd_singleton(context->world, kd_film));
}

static bool gi_is_there(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_gi_targets *gi = kd_singleton(context->world, kd_gi_targets);
    return frame->gi != KD_GI_NONE && gi->diffuse.id != 0 && gi->width == frame->width;
}

static struct kd_film_params params_of(kd_system_context *context)
{
    const kd_film *film = kd_singleton(context->world, kd_film);
    uint32_t n = kd_film_scale(film), moments = film->sub_frames ? film->sub_frames : 1;
    struct kd_film_params params = {
        .mode = {n, film->sub_frame == 0, kd_film_is_last(film), gi_is_there(context)},
        .weight = {1.0f / ((float)n * (float)n * (float)moments),
                   kd_singleton(context->world, kd_gi_targets)->unit, 0, 0}};
    memcpy(params.previous_view_projection.m, kd_singleton(context->world, kd_motion)->view_projection.m,
           sizeof params.previous_view_projection.m);
    return params;
}

static void dispatch(kd_gpu *gpu, kd_gpu_program program, const kd_picture *picture)
{
    kd_gpu_dispatch(gpu, program, (picture->shown_width + FILM_GROUP - 1) / FILM_GROUP,
                    (picture->shown_height + FILM_GROUP - 1) / FILM_GROUP, 1);
}

static kd_status film_init(kd_system_context *context)
{
    film_state *s = context->user;
    static const uint16_t texel[4] = {0};
    if (!film_needed(context))
        return KD_OK;
    s->mean = kd_gpu_make_program(context->gpu, &(kd_gpu_program_desc){.compute = "shaders/film/mean.comp"});
    s->black = kd_gpu_make_texture(
        context->gpu, &(kd_gpu_texture_desc){
                          .format = KD_RGBA16F, .width = 1, .height = 1, .data = texel, .name = "black"});
    return s->mean.id && s->black.id ? KD_OK : KD_GPU;
}

static void film_run(kd_system_context *context)
{
    const film_state *s = context->user;
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    struct kd_film_params params = params_of(context);
    kd_gpu_bind_uniform(context->gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_texture(context->gpu, KD_UNIT_PICTURE, picture->hdr);
    kd_gpu_bind_image(context->gpu, 0, picture->mean, 0, KD_IMAGE_READ_WRITE, KD_RGBA32F);
    dispatch(context->gpu, s->mean, picture);
}

static uint64_t film_bytes(const kd_system_context *context)
{
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    return (uint64_t)picture->width * picture->height * 8 +
           (uint64_t)picture->shown_width * picture->shown_height * 32;
}

/* ---- the layers ---- */

static bool layers_needed(kd_system_context *context)
{
    return kd_singleton(context->world, kd_film)->layers &&
           !kd_frame_shows_voxels(kd_singleton(context->world, kd_frame));
}

static void ensure_layers(kd_gpu *gpu, kd_film_layers *l, const kd_picture *picture, bool floats)
{
    if (l->width == picture->shown_width && l->height == picture->shown_height && l->floats == floats)
        return;
    kd_gpu_destroy_texture(gpu, l->slices);
    *l = (kd_film_layers){.floats = floats, .width = picture->shown_width, .height = picture->shown_height};
    l->slices = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_2D_ARRAY,
                                                                .format = floats ? KD_RGBA32F : KD_RGBA16F,
                                                                .width = l->width,
                                                                .height = l->height,
                                                                .depth = KD_LAYER_COUNT,
                                                                .filter = KD_NEAREST,
                                                                .name = "film layers"});
}

static kd_gpu_program find_program(kd_system_context *context, film_state *s, bool floats)
{
    const char *defines[8] = {"SHOW 0u", floats ? "LAYERS_FORMAT rgba32f" : "LAYERS_FORMAT rgba16f"};
    uint32_t kinds =
        kd_surface_kinds(kd_singleton(context->world, kd_gbuffer), kd_singleton(context->world, kd_lighting));
    if (s->tried[kinds])
        return s->layers[kinds];
    kd_surface_defines(kinds, defines + 2);
    s->tried[kinds] = true;
    s->layers[kinds] = kd_gpu_make_program(
        context->gpu, &(kd_gpu_program_desc){.compute = "shaders/film/layers.comp", .defines = defines});
    return s->layers[kinds];
}

static void bind_scene(kd_system_context *context, const film_state *s)
{
    kd_gpu *gpu = context->gpu;
    const kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    kd_surface_bind(gpu, g, kd_singleton(context->world, kd_lighting),
                    kd_singleton(context->world, kd_sky_light));
    kd_surface_bind_gathered(gpu, kd_singleton(context->world, kd_gi_targets), gi_is_there(context),
                             s->black);
    kd_gpu_bind_texture(gpu, KD_UNIT_MOTION, g->motion);
    kd_gpu_bind_texture(gpu, KD_UNIT_PICTURE, kd_singleton(context->world, kd_picture)->hdr);
}

static void layers_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    film_state *s = context->user;
    kd_film_layers *l = kd_singleton(context->world, kd_film_layers);
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    struct kd_film_params params = params_of(context);
    bool floats = kd_singleton(context->world, kd_film)->sub_frames > 1;
    ensure_layers(gpu, l, picture, floats);
    bind_scene(context, s);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_image(gpu, 0, l->slices, 0, KD_IMAGE_READ_WRITE, floats ? KD_RGBA32F : KD_RGBA16F);
    dispatch(gpu, find_program(context, s, floats), picture);
}

/* Frees the state: registered first, ends last. */
static void film_fini(kd_system_context *context)
{
    film_state *s = context->user;
    kd_film_layers *l = kd_singleton(context->world, kd_film_layers);
    kd_gpu_destroy_program(context->gpu, s->mean);
    for (int i = 0; i < KD_SURFACE_KINDS; i++)
        kd_gpu_destroy_program(context->gpu, s->layers[i]);
    kd_gpu_destroy_texture(context->gpu, s->black);
    kd_gpu_destroy_texture(context->gpu, l->slices);
    *l = (kd_film_layers){0};
    free(s);
}

kd_status kd_film_import(kd_schedule *schedule)
{
    film_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return kd_fail(KD_NO_MEMORY, "film: no memory for its state; free some");
    kd_status status = kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "film",
                          .phase = KD_PHASE_VIEW,
                          .where = KD_ON_GPU,
                          .components = {KD_USES(kd_film), KD_USES(kd_frame), KD_USES(kd_gi_targets),
                                         KD_USES(kd_motion), KD_USES(kd_picture)},
                          .resources = {{"picture", KD_USE_SAMPLED | KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE}},
                          .no_commands = true,
                          .init = film_init,
                          .run_if = film_needed,
                          .run = film_run,
                          .fini = film_fini,
                          .bytes_moved = film_bytes,
                          .user = s});
    if (status != KD_OK) {
        free(s);
        return status;
    }
    return kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "film_layers",
                          .phase = KD_PHASE_VIEW,
                          .where = KD_ON_GPU,
                          .components = {KD_USES(kd_film), KD_USES(kd_frame), KD_USES(kd_lighting),
                                         KD_USES(kd_gbuffer), KD_USES(kd_gi_targets), KD_USES(kd_sky_light),
                                         KD_USES(kd_motion), KD_USES(kd_picture), KD_CHANGES(kd_film_layers)},
                          .resources = {KD_SURFACE_RESOURCES,
                                        {"picture", KD_USE_SAMPLED},
                                        {"film.layers", KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE}},
                          .no_commands = true,
                          .run_if = layers_needed,
                          .run = layers_run,
                          .user = s});
}
