/* System octree_view: shows the octree itself, ray marched at one level, in place of the picture. */
#include "systems/debug_view/debug_view.h"

#include <stdlib.h>

#include "components/frame.h"
#include "components/render_targets.h"
#include "components/tree_access.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

typedef struct view_state {
    kd_tree_program octree;
} view_state;

static void run(kd_system_context *context)
{
    view_state *state = context->user;
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    if (!tree->radiance.id ||
        !kd_tree_fit_program(gpu, tree, "shaders/debug_view/octree.comp", &state->octree))
        return;
    int32_t level = frame->settings.view_level,
            pass[4] = {(int32_t)frame->width, (int32_t)frame->height, level < 0 ? 0 : level, 0};
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, pass, sizeof pass);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_tree_bind(gpu, tree);
    kd_gpu_bind_image(gpu, 0, picture->hdr, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_dispatch(gpu, state->octree.program, (frame->width + 7) / 8, (frame->height + 7) / 8, 1);
}

static bool asked_for(kd_system_context *context)
{
    return kd_singleton(context->world, kd_frame)->view == KD_VIEW_OCTREE;
}

static void fini(kd_system_context *context)
{
    view_state *state = context->user;
    kd_gpu_destroy_program(context->gpu, state->octree.program);
    free(state);
}

kd_status kd_debug_view_import(kd_schedule *s)
{
    view_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "octree_view",
               .phase = KD_PHASE_VIEW,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_tree), KD_USES(kd_lighting), KD_USES(kd_frame), KD_USES(kd_picture)},
               .resources = {{"tree.uniform", KD_USE_UNIFORM},
                             {"tree.radiance", KD_USE_SAMPLED},
                             {"tree.nodes", KD_USE_SAMPLED},
                             {"tree.leaves", KD_USE_SAMPLED},
                             {"tree.data", KD_USE_SAMPLED},
                             {"lights.uniform", KD_USE_UNIFORM},
                             {"picture", KD_USE_IMAGE_WRITE}},
               .run_if = asked_for,
               .no_commands = true,
               .run = run,
               .fini = fini,
               .user = state,
           });
}
