/* System gather: `--gi cones`. Traces cones from the G-buffer through the octree and brings the result to
 * picture size. */
#include "systems/cone_trace/cone_trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "components/camera.h"
#include "components/cone_set.h"
#include "components/emitters.h"
#include "components/frame.h"
#include "components/light_jump.h"
#include "components/render_targets.h"
#include "components/sky.h"
#include "components/svo.h"
#include "components/tree_access.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "runtime/gpu/work_list.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/gather.h"
#include "shaders/shared/scene.h"
#include "systems/cone_trace/grid.h"
#include "systems/cone_trace/tracers.h"

typedef struct gather_state {
    gather_tracers tracers;
    bool counts;           /* this frame is counted */
    kd_gpu_buffer samples; /* kd_gi_targets.samples */
    kd_gpu_program guide, pick, refine, smooth, smooth_list, upsample;
    gather_grid grid, coarse;    /* coarse: at twice the spacing */
    kd_gpu_texture normal_depth; /* of the grid's pixels, shaders/cone_trace/guide.comp */
    kd_gpu_texture normal_depth_before;
    /* pixels to trace, to trace with their reflections, and to smooth: shaders/cone_trace/listed_pixel.glsl
     */
    kd_gpu_buffer list, glossy_list, smooth_items;
    uint64_t traced; /* frame that left what is of use in the next, plus one; 0: none */
    kd_view seen;    /* in that frame */
    struct kd_gather_params params;
    uint32_t sky; /* its version */
} gather_state;

static void fit_own_targets(kd_gpu *gpu, gather_state *state, uint32_t width, uint32_t height)
{
    if (!grid_fit(gpu, &state->grid, width, height))
        return;
    grid_remake(gpu, &state->normal_depth, KD_RGBA32F, width, height, "gi.guide");
    grid_remake(gpu, &state->normal_depth_before, KD_RGBA32F, width, height, "gi.guide");
    state->traced = 0;
}

static void fit_targets(kd_gpu *gpu, kd_gi_targets *gi, uint32_t width, uint32_t height)
{
    if (gi->width == width && gi->height == height)
        return;
    grid_remake(gpu, &gi->diffuse, KD_RGBA16F, width, height, "gi.diffuse");
    grid_remake(gpu, &gi->specular, KD_RGBA16F, width, height, "gi.specular");
    gi->width = width;
    gi->height = height;
}

/* A ring at 60 degrees becomes four at 53 to 68: a small bright thing then leaves no ring on the wall beside
 * it. */
#define CONE_TILT 0.1f
/* Narrow cones along the normal stand at four places round it. */
#define CAP_TILT 0.25f

static struct kd_gather_params params_of(const kd_settings *s, const kd_tree *tree, const kd_gi_targets *gi)
{
    struct kd_gather_params p = {
        .size = {gi->width, gi->height, (uint32_t)s->cones_resolution, (uint32_t)s->cones_count},
        .cone = {tanf(s->cones_aperture_deg * (3.14159265f / 360)), s->cones_step,
                 kd_tree_cone_length(tree, s), s->cones_start},
        .light = {s->cones_intensity, s->ao_falloff, s->ao_intensity, s->cones_far},
        .flags = {s->specular_cones ? 1u : 0u, 0, (uint32_t)s->cones_interpolation, 0},
        .refine = {s->cones_refine, 1 / gi->unit, 0, 0},
    };
    kd_cone_set_make(p.cones, p.size.w, CONE_TILT, s->cones_far < 1 ? CAP_TILT : 0);
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

static void bind_outputs(kd_gpu *gpu, uint32_t unit, kd_gpu_texture diffuse, kd_gpu_texture specular)
{
    kd_gpu_bind_image(gpu, unit, diffuse, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_bind_image(gpu, unit + 1, specular, 0, KD_IMAGE_WRITE, KD_RGBA16F);
}

static void bind_inputs(kd_gpu *gpu, kd_gpu_texture diffuse, kd_gpu_texture specular)
{
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_DIFFUSE, diffuse);
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_SPECULAR, specular);
}

static void dispatch_pixels(kd_gpu *gpu, kd_gpu_program program, uint32_t width, uint32_t height)
{
    kd_gpu_dispatch(gpu, program, (width + 7) / 8, (height + 7) / 8, 1);
}

static void make_guide(kd_gpu *gpu, const gather_state *state, struct kd_gather_params *params, uint32_t n)
{
    params->size.z = n;
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, params, sizeof *params);
    kd_gpu_bind_image(gpu, 0, state->normal_depth, 0, KD_IMAGE_WRITE, KD_RGBA32F);
    dispatch_pixels(gpu, state->guide, state->grid.width, state->grid.height);
    kd_gpu_bind_texture(gpu, KD_UNIT_GI_GUIDE, state->normal_depth);
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
}

static void bind_pass(kd_gpu *gpu, struct kd_gather_params *params, uint32_t n, uint32_t scale)
{
    params->size.z = n;
    params->flags.y = scale;
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, params, sizeof *params);
}

static void smooth_grid(kd_gpu *gpu, const gather_state *state, const gather_grid *grid)
{
    bind_inputs(gpu, grid->diffuse[GRID_TRACED], grid->specular[GRID_TRACED]);
    bind_outputs(gpu, 0, grid->diffuse[GRID_SMOOTH], grid->specular[GRID_SMOOTH]);
    dispatch_pixels(gpu, state->smooth, grid->width, grid->height);
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
}

/* Trace and smooth all pixels of the grid, whose spacing is n. */
static void trace_all(kd_gpu *gpu, const gather_state *state, struct kd_gather_params *params, uint32_t n)
{
    const gather_grid *grid = &state->grid;
    bind_pass(gpu, params, n, 1);
    if (state->counts)
        kd_gpu_bind_storage(gpu, 1, state->samples);
    bind_outputs(gpu, 0, grid->diffuse[GRID_TRACED], grid->specular[GRID_TRACED]);
    dispatch_pixels(gpu, state->tracers.programs[TRACE_ALL][state->counts].program, grid->width,
                    grid->height);
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
    smooth_grid(gpu, state, grid);
}

static void begin_list(kd_gpu *gpu, kd_gpu_buffer list, uint32_t binding)
{
    kd_gpu_clear_work_list(gpu, list);
    kd_gpu_bind_storage(gpu, binding, list);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void bind_before(kd_gpu *gpu, const gather_state *state, const gather_grid *grid)
{
    kd_gpu_bind_texture(gpu, KD_UNIT_BEFORE_DIFFUSE, grid->diffuse[GRID_BEFORE]);
    kd_gpu_bind_texture(gpu, KD_UNIT_BEFORE_SPECULAR, grid->specular[GRID_BEFORE]);
    kd_gpu_bind_texture(gpu, KD_UNIT_BEFORE_GUIDE, state->normal_depth_before);
}

static void trace_listed(kd_gpu *gpu, const gather_state *state, const gather_grid *grid, bool glossy)
{
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT | KD_BARRIER_TEXTURE);
    if (state->counts)
        kd_gpu_bind_storage(gpu, 1, state->samples);
    bind_outputs(gpu, 0, grid->diffuse[GRID_TRACED], grid->specular[GRID_TRACED]);
    kd_gpu_dispatch_indirect(gpu, state->tracers.programs[TRACE_LIST][state->counts].program, state->list, 0);
    if (glossy) {
        kd_gpu_bind_storage(gpu, 0, state->glossy_list);
        kd_gpu_dispatch_indirect(gpu, state->tracers.programs[TRACE_GLOSSY_LIST][state->counts].program,
                                 state->glossy_list, 0);
    }
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE | KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
}

/* Trace the coarse grid of spacing 2 n, where the frame before is of no use, and smooth it. */
static void trace_coarse(kd_gpu *gpu, const gather_state *state, struct kd_gather_params *params, uint32_t n)
{
    const gather_grid *coarse = &state->coarse;
    bind_pass(gpu, params, 2 * n, 2);
    begin_list(gpu, state->list, 0);
    bind_before(gpu, state, coarse);
    bind_outputs(gpu, 0, coarse->diffuse[GRID_TRACED], coarse->specular[GRID_TRACED]);
    dispatch_pixels(gpu, state->pick, coarse->width, coarse->height);
    trace_listed(gpu, state, coarse, false);
    smooth_grid(gpu, state, coarse);
}

/* Trace the coarse grid, take from it what is good enough for the grid, and trace and smooth the rest. */
static void trace_where_needed(kd_gpu *gpu, const gather_state *state, struct kd_gather_params *params,
                               uint32_t n)
{
    const gather_grid *grid = &state->grid, *coarse = &state->coarse;
    uint32_t glossy = params->flags.x;
    params->flags.x = 0; /* glossy pixels will be listed */
    trace_coarse(gpu, state, params, n);
    params->flags.x = glossy;
    bind_pass(gpu, params, n, 1);
    begin_list(gpu, state->list, 0);
    begin_list(gpu, state->smooth_items, 1);
    begin_list(gpu, state->glossy_list, 4);
    bind_before(gpu, state, grid);
    bind_inputs(gpu, coarse->diffuse[GRID_SMOOTH], coarse->specular[GRID_SMOOTH]);
    bind_outputs(gpu, 0, grid->diffuse[GRID_TRACED], grid->specular[GRID_TRACED]);
    bind_outputs(gpu, 2, grid->diffuse[GRID_SMOOTH], grid->specular[GRID_SMOOTH]);
    dispatch_pixels(gpu, state->refine, grid->width, grid->height);
    trace_listed(gpu, state, grid, glossy != 0);
    bind_inputs(gpu, grid->diffuse[GRID_TRACED], grid->specular[GRID_TRACED]);
    bind_outputs(gpu, 0, grid->diffuse[GRID_SMOOTH], grid->specular[GRID_SMOOTH]);
    kd_gpu_bind_storage(gpu, 0, state->smooth_items);
    kd_gpu_dispatch_indirect(gpu, state->smooth_list, state->smooth_items, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
}

/* Make room for the coarse grid and the list. Returns false when everything is to be traced. */
static bool fit_refinement(kd_gpu *gpu, gather_state *state, const kd_settings *s, const gather_grid *grid)
{
    uint32_t pixels = grid->width * grid->height;
    if (s->cones_refine <= 0 || pixels > KD_WORK_LIST_MOST)
        return false;
    if (grid_fit(gpu, &state->coarse, (grid->width + 1) / 2, (grid->height + 1) / 2))
        state->traced = 0;
    return kd_gpu_fit_work_list(gpu, &state->list, pixels, "gi.refine") == KD_OK &&
           kd_gpu_fit_work_list(gpu, &state->glossy_list, pixels, "gi.glossy") == KD_OK &&
           kd_gpu_fit_work_list(gpu, &state->smooth_items, pixels, "gi.smooth") == KD_OK;
}

/* Begin to count, when that is asked for. */
static void begin_counts(kd_gpu *gpu, gather_state *state, kd_gi_targets *gi)
{
    size_t words = KD_CONE_COUNTERS + (size_t)gi->width * gi->height;
    gi->counted =
        state->counts && kd_gpu_ensure_buffer(gpu, &gi->samples, words * 4, 0, "gi.samples") == KD_OK;
    state->samples = gi->samples;
    if (!gi->counted)
        return;
    kd_gpu_fill_buffer(gpu, gi->samples, 0, words * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* What the frame before traced is of use when it was the last one, and saw with the same settings. Where
 * bounces do not feed themselves nothing is kept: a picture depends on its frame alone. */
static void begin_reuse(kd_gpu *gpu, kd_world *w, gather_state *state, struct kd_gather_params *params)
{
    const kd_frame *frame = kd_singleton(w, kd_frame);
    const kd_view *view = kd_singleton(w, kd_view);
    kd_svo *svo = kd_singleton(w, kd_svo);
    const kd_light_jump *jump = kd_singleton(w, kd_light_jump);
    uint32_t sky = kd_singleton(w, kd_sky_light)->version, period = (uint32_t)frame->settings.cones_reuse;
    bool wanted = jump->measured && period > 1;
    svo->wants_changes = svo->wants_changes || wanted;
    bool same = state->traced == frame->index && state->sky == sky &&
                memcmp(&state->params, params, sizeof *params) == 0;
    state->params = *params;
    state->sky = sky;
    grid_begin_frame(&state->grid);
    grid_begin_frame(&state->coarse);
    kd_gpu_texture before = state->normal_depth_before;
    state->normal_depth_before = state->normal_depth;
    state->normal_depth = before;
    kd_gpu_bind_storage(gpu, 2, jump->state);
    if (svo->book.id)
        kd_svo_bind_changes(gpu, svo, 3);
    if (wanted && same && svo->book.id) {
        const float *m = state->seen.view.m;
        params->reuse = (kd_gl_uvec4){period == 3 ? 2 : period, (uint32_t)frame->index, 0, 0};
        memcpy(&params->before, &state->seen.view_projection, sizeof params->before);
        params->before_eye = (kd_gl_vec4){-m[2], -m[6], -m[10], -m[14]};
    }
    state->seen = *view;
    state->traced = wanted ? frame->index + 1 : 0;
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
    state->counts = frame->settings.cones_counters || frame->view == KD_VIEW_COST;
    gi->counted = false;
    fit_own_targets(gpu, state, (frame->width + n - 1) / n, (frame->height + n - 1) / n);
    bool refines = fit_refinement(gpu, state, &frame->settings, &state->grid);
    if (!tracers_fit(gpu, &state->tracers, tree, &frame->settings, refines, state->counts))
        return;
    fit_targets(gpu, gi, frame->width, frame->height);
    begin_counts(gpu, state, gi);
    gi->unit = fmaxf(kd_singleton(w, kd_voxel_scene)->stored_unit, 1);
    struct kd_gather_params params = params_of(&frame->settings, tree, gi);
    bind_gbuffer(gpu, kd_singleton(w, kd_gbuffer), kd_singleton(w, kd_lighting));
    kd_tree_bind(gpu, tree);
    kd_emitters_bind(gpu, kd_singleton(w, kd_emitters));
    kd_sky_bind(gpu, kd_singleton(w, kd_sky_light));
    begin_reuse(gpu, w, state, &params);
    make_guide(gpu, state, &params, n);
    if (refines)
        trace_where_needed(gpu, state, &params, n);
    else
        trace_all(gpu, state, &params, n);
    bind_inputs(gpu, state->grid.diffuse[GRID_SMOOTH], state->grid.specular[GRID_SMOOTH]);
    bind_outputs(gpu, 0, gi->diffuse, gi->specular);
    dispatch_pixels(gpu, state->upsample, state->grid.width, state->grid.height);
}

/* Views of voxels show nothing of what would be gathered. */
static bool gi_is_cones(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    return frame->gi == KD_GI_CONES && !kd_frame_shows_voxels(frame);
}

static kd_status init(kd_system_context *context)
{
    gather_state *state = context->user;
    const struct {
        const char *path;
        kd_gpu_program *program;
    } programs[] = {{"shaders/cone_trace/guide.comp", &state->guide},
                    {"shaders/cone_trace/pick.comp", &state->pick},
                    {"shaders/cone_trace/refine.comp", &state->refine},
                    {"shaders/cone_trace/smooth.comp", &state->smooth},
                    {"shaders/cone_trace/smooth_list.comp", &state->smooth_list},
                    {"shaders/cone_trace/upsample.comp", &state->upsample}};
    for (size_t i = 0; i < sizeof programs / sizeof programs[0]; i++) {
        *programs[i].program =
            kd_gpu_make_program(context->gpu, &(kd_gpu_program_desc){.compute = programs[i].path});
        if (!programs[i].program->id)
            return KD_GPU;
    }
    return KD_OK;
}

static void fini(kd_system_context *context)
{
    gather_state *state = context->user;
    kd_gpu *gpu = context->gpu;
    kd_gi_targets *gi = kd_singleton(context->world, kd_gi_targets);
    tracers_destroy(gpu, &state->tracers);
    kd_gpu_destroy_program(gpu, state->guide);
    kd_gpu_destroy_program(gpu, state->pick);
    kd_gpu_destroy_program(gpu, state->refine);
    kd_gpu_destroy_program(gpu, state->smooth);
    kd_gpu_destroy_program(gpu, state->smooth_list);
    kd_gpu_destroy_program(gpu, state->upsample);
    grid_destroy(gpu, &state->grid);
    grid_destroy(gpu, &state->coarse);
    kd_gpu_destroy_texture(gpu, state->normal_depth);
    kd_gpu_destroy_texture(gpu, state->normal_depth_before);
    kd_gpu_destroy_buffer(gpu, state->list);
    kd_gpu_destroy_buffer(gpu, state->glossy_list);
    kd_gpu_destroy_buffer(gpu, state->smooth_items);
    kd_gpu_destroy_texture(gpu, gi->diffuse);
    kd_gpu_destroy_texture(gpu, gi->specular);
    kd_gpu_destroy_buffer(gpu, gi->samples);
    *gi = (kd_gi_targets){0};
    free(state);
}

kd_status kd_cone_trace_import(kd_schedule *s)
{
    gather_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(s,
                           &(kd_system_desc){
                               .name = "gather_cones",
                               .phase = KD_PHASE_GATHER,
                               .where = KD_ON_GPU,
                               .components = {KD_USES(kd_tree), KD_USES(kd_voxel_scene), KD_USES(kd_gbuffer),
                                              KD_USES(kd_lighting), KD_USES(kd_frame), KD_USES(kd_emitters),
                                              KD_USES(kd_sky_light), KD_USES(kd_view), KD_USES(kd_light_jump),
                                              KD_CHANGES(kd_svo), KD_CHANGES(kd_gi_targets)},
                               .resources = {{"tree.uniform", KD_USE_UNIFORM},
                                             {"tree.radiance", KD_USE_SAMPLED},
                                             {"tree.nodes", KD_USE_SAMPLED},
                                             {"tree.leaves", KD_USE_SAMPLED},
                                             {"tree.data", KD_USE_SAMPLED},
                                             {"emitters", KD_USE_UNIFORM},
                                             {"sky", KD_USE_UNIFORM | KD_USE_SAMPLED},
                                             {"gbuffer", KD_USE_SAMPLED},
                                             {"lights.uniform", KD_USE_UNIFORM},
                                             {"light.jump", KD_USE_STORAGE_READ},
                                             {"svo.changes", KD_USE_STORAGE_READ},
                                             {"gi", KD_USE_IMAGE_WRITE},
                                             {"gi.samples", KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE}},
                               .run_if = gi_is_cones,
                               .no_commands = true,
                               .run = run,
                               .init = init,
                               .fini = fini,
                               .user = state,
                           });
}
