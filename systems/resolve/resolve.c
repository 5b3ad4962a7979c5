/* System resolve: adds up emitted, direct and indirect light into kd_picture, or shows one of them alone. One
 * pass does it all, since reading the G-buffer costs as much as shading. Programs are made for the view and
 * the lights there are. */

#include "systems/resolve/resolve.h"

#include <stdio.h>
#include <stdlib.h>

#include "components/film.h"
#include "components/sky.h"
#include "runtime/core/log.h"
#include "systems/resolve/internal.h"

_Static_assert((unsigned)KD_VIEW_FINAL == KD_SHOW_FINAL && (unsigned)KD_VIEW_DIRECT == KD_SHOW_DIRECT &&
                   (unsigned)KD_VIEW_INDIRECT == KD_SHOW_INDIRECT && (unsigned)KD_VIEW_AO == KD_SHOW_AO &&
                   (unsigned)KD_VIEW_SPECULAR == KD_SHOW_SPECULAR &&
                   (unsigned)KD_VIEW_ALBEDO == KD_SHOW_ALBEDO && (unsigned)KD_VIEW_NORMAL == KD_SHOW_NORMAL &&
                   (unsigned)KD_VIEW_DEPTH == KD_SHOW_DEPTH && (unsigned)KD_VIEW_LIGHT == KD_SHOW_LIGHT,
               "shaders number the views as kd_view_mode does");
_Static_assert((unsigned)KD_TONEMAP_ACES == KD_CURVE_ACES &&
                   (unsigned)KD_TONEMAP_REINHARD == KD_CURVE_REINHARD &&
                   (unsigned)KD_TONEMAP_LINEAR == KD_CURVE_LINEAR,
               "shaders number the curves as kd_tonemap does");

uint32_t resolve_groups(uint32_t size, uint32_t group)
{
    return (size + group - 1) / group;
}

/* Views that systems/debug_view draws into the picture. */
static bool drawn_elsewhere(const kd_frame *frame)
{
    return frame->view > KD_VIEW_LIGHT;
}

uint32_t resolve_show(const kd_frame *frame)
{
    static const uint32_t by_channel[] = {[KD_CHANNEL_RADIANCE] = KD_SHOW_FINAL,
                                          [KD_CHANNEL_ALBEDO] = KD_SHOW_ALBEDO,
                                          [KD_CHANNEL_NORMAL] = KD_SHOW_NORMAL,
                                          [KD_CHANNEL_OPACITY] = KD_SHOW_AO,
                                          [KD_CHANNEL_CASCADE] = KD_SHOW_ALBEDO};
    if (kd_frame_shows_voxels(frame))
        return by_channel[kd_frame_channel(frame)];
    return frame->view == KD_VIEW_COST ? KD_SHOW_COST : frame->view;
}

static bool has_gi(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_gi_targets *gi = kd_singleton(context->world, kd_gi_targets);
    return frame->gi != KD_GI_NONE && gi->diffuse.id != 0 && gi->width == frame->width &&
           gi->height == frame->height;
}

struct kd_resolve_params resolve_params(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    return (struct kd_resolve_params){
        .mode = {resolve_show(frame), (uint32_t)frame->settings.view_tonemap, has_gi(context) ? 1 : 0, 0},
        .gathered = {.x = kd_singleton(context->world, kd_gi_targets)->unit}};
}

bool resolve_measures(const kd_frame *frame)
{
    uint32_t show = resolve_show(frame);
    bool light = show == KD_SHOW_FINAL || show == KD_SHOW_DIRECT || show == KD_SHOW_INDIRECT ||
                 show == KD_SHOW_SPECULAR || show == KD_SHOW_LIGHT;
    return light && frame->settings.view_auto_exposure;
}

/* Views that other systems draw after this one are brought to the screen last, and frames of which this
 * picture is a part. */
static bool tonemap_is_late(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    return drawn_elsewhere(frame) || resolve_measures(frame) ||
           kd_film_on(kd_singleton(context->world, kd_film));
}

static bool tonemap_is_due(kd_system_context *context)
{
    return tonemap_is_late(context) && kd_film_is_last(kd_singleton(context->world, kd_film));
}

static void destroy_picture(kd_gpu *gpu, kd_picture *p)
{
    const kd_gpu_texture textures[] = {p->hdr, p->ldr, p->mean, p->deep};
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        kd_gpu_destroy_texture(gpu, textures[i]);
    *p = (kd_picture){0};
}

static kd_gpu_texture make_texture(kd_gpu *gpu, kd_texture_format format, uint32_t width, uint32_t height,
                                   const char *name)
{
    return kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){
                 .format = format, .width = width, .height = height, .filter = KD_NEAREST, .name = name});
}

static void ensure_picture(kd_gpu *gpu, kd_picture *p, const kd_frame *frame, const kd_film *film)
{
    uint32_t scale = kd_film_scale(film), width = frame->width / scale, height = frame->height / scale;
    if (p->width == frame->width && p->height == frame->height && p->shown_width == width &&
        p->shown_height == height && (p->mean.id != 0) == kd_film_on(film) && (p->deep.id != 0) == film->deep)
        return;
    destroy_picture(gpu, p);
    p->hdr = make_texture(gpu, KD_RGBA16F, frame->width, frame->height, "picture hdr");
    p->ldr = make_texture(gpu, KD_RGBA8, width, height, "picture");
    if (kd_film_on(film))
        p->mean = make_texture(gpu, KD_RGBA32F, width, height, "film");
    if (film->deep)
        p->deep = make_texture(gpu, KD_RGBA16UI, width, height, "picture in 16 bits");
    p->width = frame->width;
    p->height = frame->height;
    p->shown_width = width;
    p->shown_height = height;
}

static kd_gpu_program make_program(kd_gpu *gpu, uint32_t view, uint32_t kinds, bool ldr, bool tiled)
{
    char show[16];
    snprintf(show, sizeof show, "SHOW %uu", view);
    const char *defines[9] = {show};
    int count = 1 + kd_surface_defines(kinds, defines + 1);
    if (ldr)
        defines[count++] = "LDR";
    if (tiled)
        defines[count] = "TILED";
    return kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.compute = "shaders/resolve/resolve.comp", .defines = defines});
}

static kd_gpu_program find_program(kd_system_context *context, resolve_state *s, bool tiled)
{
    uint32_t view = kd_singleton(context->world, kd_frame)->view;
    uint32_t kinds =
        kd_surface_kinds(kd_singleton(context->world, kd_gbuffer), kd_singleton(context->world, kd_lighting));
    bool ldr = !tonemap_is_late(context);
    resolve_variant *variant = &s->resolve[view][kinds][ldr][tiled];
    if (!variant->tried)
        variant->program = make_program(context->gpu, view, kinds, ldr, tiled);
    variant->tried = true;
    return variant->program;
}

static kd_status resolve_init(kd_system_context *context)
{
    static const uint16_t texel[4] = {0};
    resolve_state *s = context->user;
    s->black = kd_gpu_make_texture(
        context->gpu, &(kd_gpu_texture_desc){
                          .format = KD_RGBA16F, .width = 1, .height = 1, .data = texel, .name = "black"});
    return s->black.id != 0 ? KD_OK : KD_GPU;
}

/* Frees the state: registered first, ends last. */
static void resolve_fini(kd_system_context *context)
{
    resolve_state *s = context->user;
    resolve_variant *variants = &s->resolve[0][0][0][0];
    for (size_t i = 0; i < sizeof s->resolve / sizeof *variants; i++)
        kd_gpu_destroy_program(context->gpu, variants[i].program);
    resolve_tiles_fini(context->gpu, s);
    resolve_steady_begin(&s->steady, kd_singleton(context->world, kd_picture));
    resolve_steady_fini(context->gpu, &s->steady);
    kd_gpu_destroy_texture(context->gpu, s->black);
    destroy_picture(context->gpu, kd_singleton(context->world, kd_picture));
    free(s);
}

static void resolve_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    resolve_state *s = context->user;
    kd_picture *picture = kd_singleton(context->world, kd_picture);
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    resolve_steady_begin(&s->steady, picture);
    ensure_picture(gpu, picture, frame, kd_singleton(context->world, kd_film));
    if (drawn_elsewhere(frame))
        return;
    struct kd_resolve_params params = resolve_params(context);
    kd_surface_bind(gpu, kd_singleton(context->world, kd_gbuffer), kd_singleton(context->world, kd_lighting),
                    kd_singleton(context->world, kd_sky_light));
    kd_surface_bind_gathered(gpu, kd_singleton(context->world, kd_gi_targets), has_gi(context), s->black);
    bool tiled = resolve_tiles_run(context, s);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_image(gpu, 0, picture->hdr, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_bind_image(gpu, 1, picture->ldr, 0, KD_IMAGE_WRITE, KD_RGBA8);
    kd_gpu_dispatch(gpu, find_program(context, s, tiled), resolve_groups(picture->width, RESOLVE_GROUP),
                    resolve_groups(picture->height, RESOLVE_GROUP), 1);
    resolve_steady_run(context, &s->steady, !tonemap_is_late(context));
}

/* Texels read and written once each. */
static uint64_t pixel_bytes(const kd_system_context *context, uint64_t bytes)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    return (uint64_t)frame->width * frame->height * bytes;
}
static uint64_t resolve_bytes(const kd_system_context *context)
{
    return pixel_bytes(context, 28 + 16 + 8 + 4);
}
static uint64_t tonemap_bytes(const kd_system_context *context)
{
    return pixel_bytes(context, 8 + 4);
}

kd_status kd_resolve_import(kd_schedule *schedule)
{
    resolve_state *state = calloc(1, sizeof *state);
    if (state == NULL)
        return kd_fail(KD_NO_MEMORY, "resolve: no memory for its state; free some");
    kd_status status = kd_schedule_add(
        schedule, &(kd_system_desc){
                      .name = "resolve",
                      .phase = KD_PHASE_RESOLVE,
                      .where = KD_ON_GPU,
                      .components = {KD_USES(kd_frame), KD_USES(kd_lighting), KD_USES(kd_gbuffer),
                                     KD_USES(kd_gi_targets), KD_USES(kd_sky_light), KD_USES(kd_film),
                                     KD_USES(kd_view), KD_CHANGES(kd_picture)},
                      .resources = {KD_SURFACE_RESOURCES, {"picture", KD_USE_IMAGE_WRITE | KD_USE_SAMPLED}},
                      .init = resolve_init,
                      .no_commands = true,
                      .run = resolve_run,
                      .fini = resolve_fini,
                      .bytes_moved = resolve_bytes,
                      .user = state});
    if (status != KD_OK) {
        free(state);
        return status;
    }
    return kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "tonemap",
                          .phase = KD_PHASE_VIEW,
                          .where = KD_ON_GPU,
                          .components = {KD_USES(kd_frame), KD_USES(kd_lighting), KD_USES(kd_gi_targets),
                                         KD_USES(kd_film), KD_USES(kd_picture)},
                          .resources = {{"lights.uniform", KD_USE_UNIFORM},
                                        {"picture", KD_USE_SAMPLED | KD_USE_IMAGE_WRITE}},
                          .init = resolve_tonemap_init,
                          .run_if = tonemap_is_due,
                          .no_commands = true,
                          .run = resolve_tonemap_run,
                          .fini = resolve_tonemap_fini,
                          .bytes_moved = tonemap_bytes,
                          .user = state});
}
