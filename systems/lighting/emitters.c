/* System emitters: what glows, moving or not, becomes a short list of lights (shaders/shared/emitters.h). */
#include "systems/lighting/emitters.h"

#include <stdlib.h>

#include "components/emitters.h"
#include "components/frame.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/emitters.h"
#include "systems/lighting/leaves.h"

typedef struct emitters_state {
    kd_gpu_program sum, list;
} emitters_state;

static size_t sums_size(const kd_svo *svo)
{
    size_t blocks = (size_t)KD_EMITTER_BLOCKS * KD_EMITTER_BLOCKS * KD_EMITTER_BLOCKS;
    return svo->cascades * blocks * KD_EMITTER_WORDS * 4;
}

static void fit_buffers(kd_gpu *gpu, kd_emitters *emitters, const kd_svo *svo)
{
    if (!emitters->list.id)
        emitters->list = kd_gpu_make_buffer(
            gpu, &(kd_gpu_buffer_desc){
                     .size = sizeof(struct kd_emitters_params), .zeroed = true, .name = "emitters"});
    if (emitters->sums.id && kd_gpu_buffer_size(gpu, emitters->sums) == sums_size(svo))
        return;
    kd_gpu_destroy_buffer(gpu, emitters->sums);
    emitters->sums =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sums_size(svo), .name = "emitters.sums"});
}

static void make_list(kd_gpu *gpu, const emitters_state *state, const kd_emitters *emitters,
                      const kd_svo *svo)
{
    kd_gpu_fill_buffer(gpu, emitters->sums, 0, sums_size(svo), 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    uint32_t pass[4] = {kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2, kd_svo_moving_room(svo), 0, 0};
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, pass, sizeof pass);
    lighting_bind_leaves(gpu, svo);
    kd_gpu_bind_storage(gpu, 6, emitters->sums);
    kd_gpu_dispatch_indirect(gpu, state->sum, svo->counters, KD_ARGS_ALL * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_storage(gpu, 0, emitters->sums);
    kd_gpu_bind_storage(gpu, 1, emitters->list);
    kd_gpu_dispatch(gpu, state->list, 1, 1, 1);
}

static void run(kd_system_context *context)
{
    kd_emitters *emitters = kd_singleton(context->world, kd_emitters);
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    bool some = kd_singleton(context->world, kd_voxel_scene)->brightest_emission > 0;
    if (!svo->leaves.id)
        return;
    fit_buffers(context->gpu, emitters, svo);
    if (some)
        make_list(context->gpu, context->user, emitters, svo);
    else if (emitters->some)
        kd_gpu_fill_buffer(context->gpu, emitters->list, 0, 16, 0);
    emitters->some = some;
}

static kd_status init(kd_system_context *context)
{
    emitters_state *state = context->user;
    state->sum = kd_gpu_make_program(context->gpu,
                                     &(kd_gpu_program_desc){.compute = "shaders/lighting/emitters_sum.comp"});
    state->list = kd_gpu_make_program(
        context->gpu, &(kd_gpu_program_desc){.compute = "shaders/lighting/emitters_list.comp"});
    return state->sum.id && state->list.id ? KD_OK : KD_GPU;
}

static void fini(kd_system_context *context)
{
    emitters_state *state = context->user;
    kd_emitters *emitters = kd_singleton(context->world, kd_emitters);
    kd_gpu_destroy_program(context->gpu, state->sum);
    kd_gpu_destroy_program(context->gpu, state->list);
    kd_gpu_destroy_buffer(context->gpu, emitters->list);
    kd_gpu_destroy_buffer(context->gpu, emitters->sums);
    *emitters = (kd_emitters){0};
    free(state);
}

kd_status emitters_import(kd_schedule *s)
{
    emitters_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "emitters",
               .phase = KD_PHASE_LIGHT_INJECT,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_svo), KD_USES(kd_voxel_scene), KD_USES(kd_frame),
                              KD_CHANGES(kd_emitters)},
               .resources = {{"svo.book", KD_USE_STORAGE_READ},
                             {"svo.masks", KD_USE_STORAGE_READ},
                             {"tree.leaves", KD_USE_STORAGE_READ},
                             {"svo.cells", KD_USE_STORAGE_READ},
                             {"svo.counters", KD_USE_STORAGE_READ | KD_USE_INDIRECT},
                             {"tree.uniform", KD_USE_UNIFORM},
                             {"emitters", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE}},
               .run_if = kd_frame_needs_voxels,
               .no_commands = true,
               .run = run,
               .init = init,
               .fini = fini,
               .user = state,
           });
}
