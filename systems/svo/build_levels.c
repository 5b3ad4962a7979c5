/* Build `levels`: for each level all voxels mark the nodes that they need, then what is marked takes numbers
 * from a counter; the leaves' cells are the last level. A further pass over the voxels adds attributes.
 * Source: Yalciner 2016, section 4.5 (level by level reconstruction). */
#include "systems/svo/internal.h"

static void mark(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                 uint32_t level)
{
    uint32_t pass[4] = {level, 0, 0, 0};
    svo_bind_taken(gpu, svo, scene);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_dispatch(gpu, state->programs[SVO_TAKEN_MARK], KD_SEGMENT_VOXELS / 128,
                    scene->pages[KD_LAYER_DYNAMIC].page_count * KD_PAGE_SEGMENTS, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void take(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                 uint32_t level)
{
    uint32_t pass[4] = {level, svo->dynamic_room, 0, 0};
    uint32_t dense_groups = svo->cascades * (KD_DENSE * KD_DENSE * KD_DENSE / 64);
    if (level > 0)
        svo_args(gpu, state, svo, KD_COUNT_NEED + level - 1, svo->node_room[level - 1], 8, KD_ARGS_LIST);
    svo_bind_taken(gpu, svo, scene);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    if (level > 0)
        kd_gpu_dispatch_indirect(gpu, state->programs[SVO_TAKEN_LEVEL], svo->counters, KD_ARGS_LIST * 4);
    else
        kd_gpu_dispatch_linear(gpu, state->programs[SVO_TAKEN_LEVEL], dense_groups);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void fill(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    for (uint32_t level = 0; level <= svo_levels(svo); level++) {
        mark(gpu, state, svo, scene, level);
        take(gpu, state, svo, scene, level);
    }
    svo_add_taken(gpu, state, svo, scene);
}

void svo_build_levels(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    svo_build_taken(gpu, state, svo, scene, fill);
}
