/* System resolve: adds up emitted, direct and indirect light into kd_picture, or shows one of them alone. One
 * pass does it all, since reading the G-buffer costs as much as shading. Programs are made for the view and
 * the lights there are. */

#include "systems/resolve/resolve.h"

#include <stdio.h>
#include <stdlib.h>

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
        .mode = {resolve_show(frame), (uint32_t)frame->settings.view_tonemap, has_gi(context) ? 1 : 0, 0}};
}

bool resolve_measures(const kd_frame *frame)
{
    uint32_t show = resolve_show(frame);
    bool light = show == KD_SHOW_FINAL || show == KD_SHOW_DIRECT || show == KD_SHOW_INDIRECT ||
                 show == KD_SHOW_SPECULAR || show == KD_SHOW_LIGHT;
    return light && frame->settings.view_auto_exposure;
}

/* Views that other systems draw after this one are brought to the screen last. */
static bool tonemap_is_late(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    return drawn_elsewhere(frame) || resolve_measures(frame);
}

static void destroy_picture(kd_gpu *gpu, kd_picture *p)
{
    kd_gpu_destroy_texture(gpu, p->hdr);
    kd_gpu_destroy_texture(gpu, p->ldr);
    *p = (kd_picture){0};
}

static void ensure_picture(kd_gpu *gpu, kd_picture *p, const kd_frame *frame)
{
    if (p->width == frame->width && p->height == frame->height)
        return;
    destroy_picture(gpu, p);
    kd_gpu_texture_desc desc = {.format = KD_RGBA16F,
                                .width = frame->width,
                                .height = frame->height,
                                .filter = KD_NEAREST,
                                .name = "picture hdr"};
    p->hdr = kd_gpu_make_texture(gpu, &desc);
    desc.format = KD_RGBA8;
    desc.name = "picture";
    p->ldr = kd_gpu_make_texture(gpu, &desc);
    p->width = frame->width;
    p->height = frame->height;
}

static kd_gpu_program make_program(kd_gpu *gpu, uint32_t view, uint32_t kinds, bool ldr)
{
    char show[16];
    snprintf(show, sizeof show, "SHOW %uu", view);
    const char *defines[8] = {show};
    int count = 1;
    if (kinds & 1)
        defines[count++] = "DIRECTIONAL";
    if (kinds & 2)
        defines[count++] = "LOCAL";
    if (kinds & 4)
        defines[count++] = "BLENDED";
    if (kinds & 8)
        defines[count++] = "TINTED";
    if (kinds & 16)
        defines[count++] = "LAYERED";
    if (ldr)
        defines[count] = "LDR";
    return kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.compute = "shaders/resolve/resolve.comp", .defines = defines});
}

static kd_gpu_program find_program(kd_system_context *context, resolve_state *s)
{
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    uint32_t view = kd_singleton(context->world, kd_frame)->view;
    uint32_t kinds = (lighting->directional_count > 0 ? 1u : 0u) |
                     (lighting->light_count > lighting->directional_count ? 2u : 0u) |
                     (g->blended.id != 0 ? 4u : 0u) | (g->blended_hidden.id != 0 ? 8u : 0u) |
                     (g->layers.id != 0 ? 16u : 0u);
    bool ldr = !tonemap_is_late(context);
    resolve_variant *variant = &s->resolve[view][kinds][ldr];
    if (!variant->tried)
        variant->program = make_program(context->gpu, view, kinds, ldr);
    variant->tried = true;
    return variant->program;
}

static void bind_scene(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    const kd_gbuffer *g = kd_singleton(context->world, kd_gbuffer);
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_ALBEDO, g->albedo);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_NORMAL, g->normal);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_MATERIAL, g->material);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_EMISSIVE, g->emissive);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_DEPTH, g->depth);
    kd_sky_bind(gpu, kd_singleton(context->world, kd_sky_light));
    if (g->blended.id != 0)
        kd_gpu_bind_texture(gpu, KD_UNIT_BLENDED, g->blended);
    if (g->blended_hidden.id != 0)
        kd_gpu_bind_texture(gpu, KD_UNIT_BLENDED_TINT, g->blended_hidden);
    if (g->layers.id != 0)
        kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_LAYERS, g->layers);
    kd_gpu_bind_texture(gpu, KD_UNIT_SHADOW_DIRECTIONAL, lighting->shadow_directional);
    kd_gpu_bind_texture(gpu, KD_UNIT_SHADOW_SPOT, lighting->shadow_spot);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_LIGHTS, lighting->lights, 0, sizeof(struct kd_lights_params));
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
    resolve_variant *variants = &s->resolve[0][0][0];
    for (size_t i = 0; i < sizeof s->resolve / sizeof *variants; i++)
        kd_gpu_destroy_program(context->gpu, variants[i].program);
    kd_gpu_destroy_texture(context->gpu, s->black);
    destroy_picture(context->gpu, kd_singleton(context->world, kd_picture));
    free(s);
}

static void resolve_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    resolve_state *s = context->user;
    const kd_gi_targets *gi = kd_singleton(context->world, kd_gi_targets);
    kd_picture *picture = kd_singleton(context->world, kd_picture);
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    bool gi_is_there = has_gi(context);
    ensure_picture(gpu, picture, frame);
    if (drawn_elsewhere(frame))
        return;
    struct kd_resolve_params params = resolve_params(context);
    bind_scene(context);
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_DIFFUSE, gi_is_there ? gi->diffuse : s->black);
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_SPECULAR,
                        gi_is_there && gi->specular.id != 0 ? gi->specular : s->black);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_image(gpu, 0, picture->hdr, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_bind_image(gpu, 1, picture->ldr, 0, KD_IMAGE_WRITE, KD_RGBA8);
    kd_gpu_dispatch(gpu, find_program(context, s), resolve_groups(picture->width, RESOLVE_GROUP),
                    resolve_groups(picture->height, RESOLVE_GROUP), 1);
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
        schedule, &(kd_system_desc){.name = "resolve",
                                    .phase = KD_PHASE_RESOLVE,
                                    .where = KD_ON_GPU,
                                    .components = {KD_USES(kd_frame), KD_USES(kd_lighting),
                                                   KD_USES(kd_gbuffer), KD_USES(kd_gi_targets),
                                                   KD_USES(kd_sky_light), KD_CHANGES(kd_picture)},
                                    .resources = {{"gbuffer", KD_USE_SAMPLED},
                                                  {"blended", KD_USE_SAMPLED},
                                                  {"sky", KD_USE_UNIFORM | KD_USE_SAMPLED},
                                                  {"shadow.maps", KD_USE_SAMPLED},
                                                  {"lights.uniform", KD_USE_UNIFORM},
                                                  {"gi", KD_USE_SAMPLED},
                                                  {"picture", KD_USE_IMAGE_WRITE}},
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
    return kd_schedule_add(schedule,
                           &(kd_system_desc){.name = "tonemap",
                                             .phase = KD_PHASE_VIEW,
                                             .where = KD_ON_GPU,
                                             .components = {KD_USES(kd_frame), KD_USES(kd_lighting),
                                                            KD_USES(kd_gi_targets), KD_USES(kd_picture)},
                                             .resources = {{"lights.uniform", KD_USE_UNIFORM},
                                                           {"picture", KD_USE_SAMPLED | KD_USE_IMAGE_WRITE}},
                                             .init = resolve_tonemap_init,
                                             .run_if = tonemap_is_late,
                                             .no_commands = true,
                                             .run = resolve_tonemap_run,
                                             .fini = resolve_tonemap_fini,
                                             .bytes_moved = tonemap_bytes,
                                             .user = state});
}
