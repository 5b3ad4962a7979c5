/* System view_cost: `--view cost` shows the samples that cones took, which system gather_cones counts for it.
 */
#include <stdlib.h>

#include "shaders/shared/bindings.h"
#include "systems/debug_view/internal.h"

typedef struct cost_view {
    kd_gpu_program program;
} cost_view;

static void run(kd_system_context *context)
{
    cost_view *v = context->user;
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_gi_targets *gi = kd_singleton(context->world, kd_gi_targets);
    debug_view_begin(context);
    if (frame->gi != KD_GI_CONES || !gi->counted)
        return;
    if (!v->program.id)
        v->program =
            kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/debug_view/cost.comp"});
    const struct kd_debug_view_params params = {
        .view = {frame->width, frame->height, (uint32_t)frame->settings.cones_resolution, 0}};
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_storage(gpu, 1, gi->samples);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_DEPTH, kd_singleton(context->world, kd_gbuffer)->depth);
    debug_view_dispatch(context, v->program);
}

static bool asked_for(kd_system_context *context)
{
    return kd_singleton(context->world, kd_frame)->view == KD_VIEW_COST;
}

static void fini(kd_system_context *context)
{
    cost_view *v = context->user;
    kd_gpu_destroy_program(context->gpu, v->program);
    free(v);
}

kd_status debug_view_add_cost(kd_schedule *s)
{
    cost_view *v = calloc(1, sizeof *v);
    if (!v)
        return KD_NO_MEMORY;
    return kd_schedule_add(s,
                           &(kd_system_desc){
                               .name = "view_cost",
                               .phase = KD_PHASE_VIEW,
                               .where = KD_ON_GPU,
                               .components = {KD_USES(kd_gi_targets), KD_USES(kd_gbuffer), KD_USES(kd_frame),
                                              KD_USES(kd_lighting), KD_USES(kd_picture)},
                               .resources = {{"gi.samples", KD_USE_STORAGE_READ},
                                             {"gbuffer", KD_USE_SAMPLED},
                                             {"lights.uniform", KD_USE_UNIFORM},
                                             {"picture", KD_USE_IMAGE_WRITE | KD_USE_COPY_WRITE}},
                               .run_if = asked_for,
                               .no_commands = true,
                               .run = run,
                               .fini = fini,
                               .user = v,
                           });
}
