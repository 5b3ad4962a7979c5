/* System gather: `--gi cones`. Traces cones from the G-buffer through the octree and brings the result to
 * picture size. */
#include "systems/cone_trace/cone_trace.h"

#include <math.h>
#include <stdlib.h>

#include "components/camera.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "components/tree_access.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/gather.h"
#include "shaders/shared/scene.h"
#include "systems/cone_trace/cones.h"

typedef struct gather_state {
    kd_tree_program gather;
    kd_gpu_program smooth, upsample;
    kd_gpu_texture diffuse[2], specular[2]; /* traced pixels, and smoothed ones */
    uint32_t width, height;
} gather_state;

static kd_gpu_texture make_target(kd_gpu *gpu, uint32_t width, uint32_t height, const char *name)
{
    return kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){
                 .format = KD_RGBA16F, .width = width, .height = height, .filter = KD_NEAREST, .name = name});
}

static void remake(kd_gpu *gpu, kd_gpu_texture *texture, uint32_t width, uint32_t height, const char *name)
{
    kd_gpu_destroy_texture(gpu, *texture);
    *texture = make_target(gpu, width, height, name);
}

static void fit_targets(kd_gpu *gpu, gather_state *state, kd_gi_targets *gi, uint32_t width, uint32_t height,
                        uint32_t n)
{
    uint32_t w = (width + n - 1) / n, h = (height + n - 1) / n;
    if (gi->width != width || gi->height != height) {
        remake(gpu, &gi->diffuse, width, height, "gi.diffuse");
        remake(gpu, &gi->specular, width, height, "gi.specular");
        gi->width = width;
        gi->height = height;
    }
    if (state->width != w || state->height != h) {
        for (int i = 0; i < 2; i++) {
            remake(gpu, &state->diffuse[i], w, h, "gi.diffuse.traced");
            remake(gpu, &state->specular[i], w, h, "gi.specular.traced");
        }
        state->width = w;
        state->height = h;
    }
}

/* A ring at 60 degrees becomes four at 53 to 68: a small bright thing then leaves no ring on the wall beside
 * it. */
#define CONE_TILT 0.1f

static struct kd_gather_params params_of(const kd_settings *s, const kd_tree *tree, uint32_t width,
                                         uint32_t height)
{
    float reach = tree->span_m[tree->cascade_count - 1] * (float)tree->resolution * 1.7320508f;
    struct kd_gather_params p = {
        .size = {width, height, (uint32_t)s->cones_resolution, (uint32_t)s->cones_count},
        .cone = {tanf(s->cones_aperture_deg * (3.14159265f / 360)), s->cones_step,
                 s->cones_max_distance > 0 ? s->cones_max_distance : reach, s->cones_start},
        .light = {s->cones_intensity, s->ao_falloff, s->ao_intensity, s->light_ambient},
        .flags = {s->specular_cones ? 1u : 0u, 0, 0, 0},
    };
    kd_vec4 cones[KD_MAX_CONES];
    p.cone_turn.x = 0.25f * cones_make(cones, p.size.w);
    p.cone_turn.y = CONE_TILT;
    for (uint32_t i = 0; i < p.size.w; i++)
        p.cones[i] = (kd_gl_vec4){cones[i].x, cones[i].y, cones[i].z, cones[i].w};
    return p;
}

static void bind_gbuffer(kd_gpu *gpu, const kd_gbuffer *g, const kd_lighting *lighting)
{
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_ALBEDO, g->albedo);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_NORMAL, g->normal);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_MATERIAL, g->material);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_EMISSIVE, g->emissive);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_DEPTH, g->depth);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
}

static void trace(kd_gpu *gpu, const gather_state *state, const kd_tree *tree)
{
    kd_tree_bind(gpu, tree);
    kd_gpu_bind_image(gpu, 0, state->diffuse[0], 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_bind_image(gpu, 1, state->specular[0], 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_dispatch(gpu, state->gather.program, (state->width + 7) / 8, (state->height + 7) / 8, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
}

static void refine(kd_gpu *gpu, kd_gpu_program program, kd_gpu_texture diffuse_in, kd_gpu_texture specular_in,
                   kd_gpu_texture diffuse_out, kd_gpu_texture specular_out, uint32_t width, uint32_t height)
{
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_DIFFUSE, diffuse_in);
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_SPECULAR, specular_in);
    kd_gpu_bind_image(gpu, 0, diffuse_out, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_bind_image(gpu, 1, specular_out, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_dispatch(gpu, program, (width + 7) / 8, (height + 7) / 8, 1);
}

static void run(kd_system_context *context)
{
    gather_state *state = context->user;
    kd_world *w = context->world;
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(w, kd_frame);
    const kd_tree *tree = kd_singleton(w, kd_tree);
    kd_gi_targets *gi = kd_singleton(w, kd_gi_targets);
    uint32_t n = (uint32_t)frame->settings.cones_resolution;
    if (!tree->radiance.id ||
        !kd_tree_fit_program(gpu, tree, "shaders/cone_trace/gather.comp", &state->gather))
        return;
    fit_targets(gpu, state, gi, frame->width, frame->height, n);
    struct kd_gather_params params = params_of(&frame->settings, tree, frame->width, frame->height);
    bind_gbuffer(gpu, kd_singleton(w, kd_gbuffer), kd_singleton(w, kd_lighting));
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    trace(gpu, state, tree);
    kd_gpu_texture smooth_diffuse = n == 1 ? gi->diffuse : state->diffuse[1];
    kd_gpu_texture smooth_specular = n == 1 ? gi->specular : state->specular[1];
    refine(gpu, state->smooth, state->diffuse[0], state->specular[0], smooth_diffuse, smooth_specular,
           state->width, state->height);
    if (n == 1)
        return;
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
    refine(gpu, state->upsample, smooth_diffuse, smooth_specular, gi->diffuse, gi->specular, frame->width,
           frame->height);
}

static bool gi_is_cones(kd_system_context *context)
{
    return kd_singleton(context->world, kd_frame)->gi == KD_GI_CONES;
}

static kd_status init(kd_system_context *context)
{
    gather_state *state = context->user;
    state->upsample = kd_gpu_make_program(
        context->gpu, &(kd_gpu_program_desc){.compute = "shaders/cone_trace/upsample.comp"});
    state->smooth = kd_gpu_make_program(context->gpu,
                                        &(kd_gpu_program_desc){.compute = "shaders/cone_trace/smooth.comp"});
    return state->upsample.id && state->smooth.id ? KD_OK : KD_GPU;
}

static void fini(kd_system_context *context)
{
    gather_state *state = context->user;
    kd_gi_targets *gi = kd_singleton(context->world, kd_gi_targets);
    kd_gpu_destroy_program(context->gpu, state->gather.program);
    kd_gpu_destroy_program(context->gpu, state->upsample);
    kd_gpu_destroy_program(context->gpu, state->smooth);
    for (int i = 0; i < 2; i++) {
        kd_gpu_destroy_texture(context->gpu, state->diffuse[i]);
        kd_gpu_destroy_texture(context->gpu, state->specular[i]);
    }
    kd_gpu_destroy_texture(context->gpu, gi->diffuse);
    kd_gpu_destroy_texture(context->gpu, gi->specular);
    *gi = (kd_gi_targets){0};
    free(state);
}

kd_status kd_cone_trace_import(kd_schedule *s)
{
    gather_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "gather_cones",
                                  .phase = KD_PHASE_GATHER,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_tree), KD_USES(kd_gbuffer), KD_USES(kd_lighting),
                                                 KD_USES(kd_frame), KD_CHANGES(kd_gi_targets)},
                                  .resources = {{"tree.uniform", KD_USE_UNIFORM},
                                                {"tree.radiance", KD_USE_SAMPLED},
                                                {"tree.nodes", KD_USE_SAMPLED},
                                                {"tree.leaves", KD_USE_SAMPLED},
                                                {"tree.data", KD_USE_SAMPLED},
                                                {"gbuffer", KD_USE_SAMPLED},
                                                {"lights.uniform", KD_USE_UNIFORM},
                                                {"gi", KD_USE_IMAGE_WRITE}},
                                  .run_if = gi_is_cones,
                                  .no_commands = true,
                                  .run = run,
                                  .init = init,
                                  .fini = fini,
                                  .user = state,
                              });
}
