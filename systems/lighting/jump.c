/* System light_jump: tells who keeps light from frame to frame that it has changed too much
 * (shaders/shared/jump.h). */
#include "systems/lighting/jump.h"

#include <stdlib.h>

#include "components/emitters.h"
#include "components/frame.h"
#include "components/light_jump.h"
#include "components/render_targets.h"
#include "components/tree_access.h"
#include "shaders/shared/jump.h"

typedef struct jump_state {
    kd_gpu_program program;
} jump_state;

static void run(kd_system_context *context)
{
    const jump_state *state = context->user;
    kd_gpu *gpu = context->gpu;
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    const kd_emitters *emitters = kd_singleton(context->world, kd_emitters);
    kd_light_jump *jump = kd_singleton(context->world, kd_light_jump);
    jump->measured = tree->radiance.id && emitters->list.id;
    if (!jump->measured)
        return;
    kd_tree_bind(gpu, tree);
    kd_emitters_bind(gpu, emitters);
    kd_gpu_bind_storage(gpu, 1, jump->state);
    kd_gpu_dispatch(gpu, state->program, 1, 1, 1);
}

/* Where bounces do not feed themselves a picture depends on its frame alone: nothing is kept. */
static bool light_is_kept(kd_system_context *context)
{
    kd_light_jump *jump = kd_singleton(context->world, kd_light_jump);
    jump->measured = false;
    return kd_frame_needs_voxels(context) &&
           kd_singleton(context->world, kd_frame)->settings.light_bounces == KD_BOUNCES_INF;
}

static kd_status init(kd_system_context *context)
{
    jump_state *state = context->user;
    state->program =
        kd_gpu_make_program(context->gpu, &(kd_gpu_program_desc){.compute = "shaders/lighting/jump.comp"});
    kd_light_jump *jump = kd_singleton(context->world, kd_light_jump);
    jump->state = kd_gpu_make_buffer(
        context->gpu, &(kd_gpu_buffer_desc){.size = KD_JUMP_WORDS * 4, .zeroed = true, .name = "light.jump"});
    return state->program.id && jump->state.id ? KD_OK : KD_GPU;
}

static void fini(kd_system_context *context)
{
    jump_state *state = context->user;
    kd_light_jump *jump = kd_singleton(context->world, kd_light_jump);
    kd_gpu_destroy_program(context->gpu, state->program);
    kd_gpu_destroy_buffer(context->gpu, jump->state);
    *jump = (kd_light_jump){0};
    free(state);
}

kd_status jump_import(kd_schedule *s)
{
    jump_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "light_jump",
                                  .phase = KD_PHASE_BOUNCE,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_tree), KD_USES(kd_emitters), KD_USES(kd_frame),
                                                 KD_CHANGES(kd_light_jump)},
                                  .resources = {{"tree.uniform", KD_USE_UNIFORM},
                                                {"tree.radiance", KD_USE_SAMPLED},
                                                {"emitters", KD_USE_UNIFORM},
                                                {"light.jump", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE}},
                                  .run_if = light_is_kept,
                                  .no_commands = true,
                                  .run = run,
                                  .init = init,
                                  .fini = fini,
                                  .user = state,
                              });
}
