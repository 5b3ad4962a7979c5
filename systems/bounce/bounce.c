/* Systems bounce_prepare and bounce: `light.bounces`. A dense cell gathers, side by side, the light that
 * arrives there; leaves send it out again when light enters the tree for the next time: in the next frame,
 * and in a frame without a past (or when exactly two bounces are asked for) at once. */
#include "systems/bounce/bounce.h"

#include <math.h>
#include <stdlib.h>

#include "components/bounce.h"
#include "components/cone_set.h"
#include "components/emitters.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "components/sky.h"
#include "components/svo.h"
#include "components/tree_access.h"
#include "runtime/gpu/work_list.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/bounce.h"
#include "components/light.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "components/voxel_scene.h"
#include "systems/bounce/sources.h"

/* Every cell has its turn in this many frames while light feeds itself. */
static const uint32_t TURNS = 8;

/* Frames in which every cell gathers after light has begun anew: what is left to come is then less than a
 * hundredth. */
static const uint32_t SETTLING = 6;

typedef struct bounce_state {
    kd_tree_program gather;
    kd_gpu_program select;
    kd_gpu_buffer items; /* shaders/bounce/side_item.glsl */
} bounce_state;

static bool keeps_entries(const kd_frame *frame)
{
    return frame->settings.light_bounces >= KD_BOUNCES_TWO;
}

static void prepare(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    kd_bounce *bounce = kd_singleton(context->world, kd_bounce);
    bool keeps = keeps_entries(frame), endless = frame->settings.light_bounces == KD_BOUNCES_INF;
    size_t cells = keeps ? (size_t)svo->cascades << (3 * KD_DENSE_LOG2) : 1,
           size = cells * KD_BOUNCE_WORDS * 4;
    bool made = !bounce->entries.id || kd_gpu_buffer_size(context->gpu, bounce->entries) != size;
    if (made) {
        kd_gpu_destroy_texture(context->gpu, bounce->view);
        kd_gpu_destroy_buffer(context->gpu, bounce->entries);
        bounce->entries = kd_gpu_make_buffer(
            context->gpu, &(kd_gpu_buffer_desc){.size = size, .zeroed = true, .name = "bounce"});
        bounce->view = kd_gpu_make_texel_buffer(context->gpu, bounce->entries, KD_R32UI);
        bounce->frame = 2 * KD_BOUNCE_MAX_TURNS * TURNS; /* zeroed entries are old */
    }
    bounce->frame++;
    bool jumped = light_sources_jumped(context->user, context->world);
    bounce->feeds = endless && !made && !jumped;
    bounce->again = keeps && !bounce->feeds;
    bounce->settling = bounce->feeds ? bounce->settling - (bounce->settling > 0) : SETTLING;
    bounce->period = bounce->settling > 0 ? 1 : TURNS;
}

static bool keeps(kd_system_context *context)
{
    return kd_frame_needs_voxels(context) && keeps_entries(kd_singleton(context->world, kd_frame));
}

static uint32_t room_for_items(const kd_svo *svo)
{
    uint64_t sides = 6 * (uint64_t)svo->node_capacity;
    return sides < KD_WORK_LIST_MOST ? (uint32_t)sides : KD_WORK_LIST_MOST;
}

static struct kd_bounce_params params_of(const kd_settings *s, const kd_svo *svo, const kd_tree *tree,
                                         const kd_bounce *bounce)
{
    struct kd_bounce_params p = {
        .work = {svo->mask_words[0], svo->mask_first[0], 0, 0},
        .frame = {bounce->frame, bounce->period, bounce->period * KD_BOUNCE_MAX_TURNS, 0},
        .cone = {tanf(s->cones_aperture_deg * (3.14159265f / 360)), s->cones_step,
                 kd_tree_cone_length(tree, s), s->cones_intensity},
        .far = {s->cones_far, 0, 0, 0},
    };
    kd_cone_set_make(p.cones, KD_BOUNCE_CONES, 0, 0);
    return p;
}

static void run(kd_system_context *context)
{
    bounce_state *state = context->user;
    kd_gpu *gpu = context->gpu;
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    const kd_bounce *bounce = kd_singleton(context->world, kd_bounce);
    if (!tree->radiance.id || !bounce->entries.id ||
        !kd_tree_fit_program(gpu, tree, "shaders/bounce/gather.comp", &state->gather) ||
        kd_gpu_fit_work_list(gpu, &state->items, room_for_items(svo), "bounce.items") != KD_OK)
        return;
    struct kd_bounce_params params =
        params_of(&kd_singleton(context->world, kd_frame)->settings, svo, tree, bounce);
    kd_gpu_clear_work_list(gpu, state->items);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_tree_bind(gpu, tree);
    kd_emitters_bind(gpu, kd_singleton(context->world, kd_emitters));
    kd_sky_bind(gpu, kd_singleton(context->world, kd_sky_light));
    kd_gpu_bind_storage(gpu, 0, state->items);
    kd_gpu_bind_storage(gpu, 1, bounce->entries);
    kd_gpu_bind_storage(gpu, 2, svo->level_masks);
    kd_gpu_dispatch(gpu, state->select, (svo->mask_words[0] + 63) / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
    if (!bounce->settled) /* else what they hold is what they would gather, but it stays fresh */
        kd_gpu_dispatch_indirect(gpu, state->gather.program, state->items, 0);
}

static kd_status init(kd_system_context *context)
{
    bounce_state *state = context->user;
    state->select =
        kd_gpu_make_program(context->gpu, &(kd_gpu_program_desc){.compute = "shaders/bounce/select.comp"});
    return state->select.id ? KD_OK : KD_GPU;
}

static void fini(kd_system_context *context)
{
    bounce_state *state = context->user;
    kd_bounce *bounce = kd_singleton(context->world, kd_bounce);
    kd_gpu_destroy_program(context->gpu, state->gather.program);
    kd_gpu_destroy_program(context->gpu, state->select);
    kd_gpu_destroy_buffer(context->gpu, state->items);
    kd_gpu_destroy_texture(context->gpu, bounce->view);
    kd_gpu_destroy_buffer(context->gpu, bounce->entries);
    *bounce = (kd_bounce){0};
    free(state);
}

static kd_status init_sources(kd_system_context *context)
{
    return light_sources_init(context->user, context->world);
}

static void fini_sources(kd_system_context *context)
{
    light_sources_fini(context->user);
    free(context->user);
}

kd_status kd_bounce_import(kd_schedule *s)
{
    bounce_state *state = calloc(1, sizeof *state);
    light_sources *sources = calloc(1, sizeof *sources);
    if (!state || !sources) {
        free(state);
        free(sources);
        return KD_NO_MEMORY;
    }
    kd_status status = kd_schedule_add(
        s, &(kd_system_desc){
               .name = "bounce_prepare",
               .phase = KD_PHASE_VOXEL_TRANSFORM,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_svo), KD_USES(kd_frame), KD_USES(kd_voxel_scene),
                              KD_USES(kd_scene_store), KD_USES(kd_light), KD_USES(kd_world_transform),
                              KD_USES(kd_sky), KD_USES(kd_sky_images), KD_CHANGES(kd_bounce)},
               .resources = {{"bounce", KD_USE_COPY_WRITE}},
               .run_if = kd_frame_needs_voxels,
               .no_commands = true,
               .run = prepare,
               .init = init_sources,
               .fini = fini_sources,
               .user = sources,
           });
    if (status)
        return status;
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "bounce",
               .phase = KD_PHASE_BOUNCE,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_svo), KD_USES(kd_tree), KD_USES(kd_frame), KD_USES(kd_emitters),
                              KD_USES(kd_bounce), KD_USES(kd_sky_light)},
               .resources = {{"svo.levels", KD_USE_STORAGE_READ},
                             {"tree.uniform", KD_USE_UNIFORM},
                             {"tree.radiance", KD_USE_SAMPLED},
                             {"tree.nodes", KD_USE_SAMPLED},
                             {"tree.leaves", KD_USE_SAMPLED},
                             {"tree.data", KD_USE_SAMPLED},
                             {"emitters", KD_USE_UNIFORM},
                             {"sky", KD_USE_UNIFORM | KD_USE_SAMPLED},
                             {"bounce", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE}},
               .run_if = keeps,
               .no_commands = true,
               .run = run,
               .init = init,
               .fini = fini,
               .user = state,
           });
}
