/* System voxel_transform: marks what voxels cover. The dynamic layer goes every frame, its voxels are brought
 * to the world and kept in the pages for their cells; they mark leaf parents. Of the static layer only what
 * lies in stale parts goes: groups of voxels are culled against these, and those left are listed for the
 * tree's build. */
#include "systems/voxel_transform/voxel_transform.h"

#include <stdlib.h>

#include "components/frame.h"
#include "components/rigid_access.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/voxel_transform/moving.h"

typedef struct transform_state {
    kd_gpu_program patches, cull, cull_args;
    kd_rigid_access rigid;
    kd_texel_view bounds_view, boxes_view;
    moving_voxels moving;
    uint64_t bytes;
} transform_state;

static void number_patches(kd_gpu *gpu, const transform_state *state, const kd_voxel_scene *scene)
{
    uint32_t pass[4] = {scene->stale_patch_count, 0, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 0, scene->stale);
    kd_gpu_dispatch_linear(gpu, state->patches, (scene->stale_patch_count + 63) / 64);
}

/* List the groups of static voxels that may lie in stale parts. */
static kd_status cull_static(kd_gpu *gpu, transform_state *state, kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_STATIC];
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS, groups = slots * KD_SEGMENT_GROUPS;
    size_t lists = (size_t)scene->stale_places.groups * 4;
    kd_status status =
        kd_gpu_ensure_buffer(gpu, &scene->stale, lists + (size_t)groups * 4, lists, "voxels.stale");
    if (status)
        return status;
    uint32_t pass[4] = {slots, scene->stale_box_count, 0, 0};
    kd_gpu_fill_buffer(gpu, scene->stale, 0, KD_STALE_HEAD * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    number_patches(gpu, state, scene);
    kd_rigid_access_bind(gpu, &state->rigid, scene);
    kd_texel_view_bind(gpu, &state->bounds_view, KD_RIGID_VIEWS, pages->bounds, KD_RG32UI);
    kd_texel_view_bind(gpu, &state->boxes_view, KD_RIGID_VIEWS + 1, scene->stale_boxes, KD_RGBA32UI);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_dispatch_linear(gpu, state->cull, (slots + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch(gpu, state->cull_args, 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
    return KD_OK;
}

static void list_static(kd_gpu *gpu, transform_state *state, kd_voxel_scene *scene)
{
    if (!scene->pages[KD_LAYER_STATIC].segment_count) /* nothing is there any more */
        number_patches(gpu, state, scene);
    else if (cull_static(gpu, state, scene) != KD_OK) {
        kd_gpu_fill_buffer(gpu, scene->stale, 0, KD_STALE_HEAD * 4, 0); /* none are listed */
        kd_log(KD_LOG_WARNING, "voxel transform: no memory to list static voxels; some are left out");
    }
}

static void transform_dynamic(kd_system_context *context, transform_state *state, const kd_voxel_scene *scene,
                              const kd_svo *svo)
{
    if (moving_transform(context, &state->moving, scene, svo) != KD_OK)
        kd_log(KD_LOG_WARNING, "voxel transform: no memory to list moving voxels; they stay as they are");
    state->bytes += scene->pages[KD_LAYER_DYNAMIC].voxel_count * (8 + 4 + KD_PAGE_WORDS * 4);
}

static void run(kd_system_context *context)
{
    transform_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    kd_gpu *gpu = context->gpu;
    state->bytes = 0;
    if (!svo->masks.id)
        return;
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, svo->uniform, 0, sizeof(struct kd_tree_params));
    if (scene->static_changed)
        list_static(gpu, state, scene);
    bool takes = scene->build != KD_SVO_BUILD_ORDERFREE; /* and needs no bits */
    if (svo->has_moving)
        kd_gpu_fill_buffer(gpu, svo->moving, 0, (size_t)kd_svo_parent_words(svo) * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    if (scene->pages[KD_LAYER_DYNAMIC].segment_count && (svo->has_moving || takes))
        transform_dynamic(context, state, scene, svo);
    else
        moving_rest(gpu, &state->moving);
}

static uint64_t bytes_moved(const kd_system_context *context)
{
    return ((const transform_state *)context->user)->bytes;
}

static kd_gpu_program program(kd_gpu *gpu, const char *path)
{
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path});
}

static kd_status init(kd_system_context *context)
{
    transform_state *state = context->user;
    kd_gpu *gpu = context->gpu;
    state->patches = program(gpu, "shaders/voxel_transform/patches.comp");
    state->cull = program(gpu, "shaders/voxel_transform/cull.comp");
    state->cull_args = program(gpu, "shaders/voxel_transform/cull_args.comp");
    bool all = state->patches.id && state->cull.id && state->cull_args.id;
    kd_status status = moving_init(gpu, &state->moving);
    return all ? status : KD_GPU;
}

static void fini(kd_system_context *context)
{
    transform_state *state = context->user;
    kd_gpu_program programs[] = {state->patches, state->cull, state->cull_args};
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        kd_gpu_destroy_program(context->gpu, programs[i]);
    kd_rigid_access_fini(context->gpu, &state->rigid);
    kd_texel_view_fini(context->gpu, &state->bounds_view);
    kd_texel_view_fini(context->gpu, &state->boxes_view);
    moving_fini(context->gpu, &state->moving);
    free(state);
}

static bool marks_again(kd_system_context *context)
{
    return kd_frame_needs_voxels(context) && kd_singleton(context->world, kd_svo)->again;
}

/* Once more when the tree had not room for all that was marked. */
static kd_status add(kd_schedule *s, transform_state *state, bool again)
{
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = again ? "voxel_transform_again" : "voxel_transform",
               .phase = again ? KD_PHASE_VOXEL_AGAIN : KD_PHASE_VOXEL_TRANSFORM,
               .where = KD_ON_GPU,
               .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_svo), KD_USES(kd_frame),
                              KD_USES(kd_scene_store), KD_USES(kd_joint_palette)},
               .resources = {{"voxels.pages", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_SAMPLED},
                             {"voxels.objects", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                             {"voxels.chunks", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                             {"voxels.cache", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                             {"scene.vertices", KD_USE_SAMPLED},
                             {"scene.indices", KD_USE_SAMPLED},
                             {"scene.joints", KD_USE_SAMPLED},
                             {"tree.uniform", KD_USE_UNIFORM},
                             {"voxels.stale", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_SAMPLED |
                                                  KD_USE_COPY_WRITE},
                             {"svo.masks", KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE}},
               .run_if = again ? marks_again : kd_frame_needs_voxels,
               .no_commands = true,
               .run = run,
               .bytes_moved = bytes_moved,
               .init = again ? NULL : init,
               .fini = again ? NULL : fini,
               .user = state,
           });
}

kd_status kd_voxel_transform_import(kd_schedule *s)
{
    transform_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    kd_status status = add(s, state, false);
    return status ? status : add(s, state, true);
}
