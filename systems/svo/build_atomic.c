/* Build `atomic`: one pass over the voxels; each goes down from the root, makes what is missing under a lock
 * in the word that leads there, and adds its attributes to the cell's sums. A voxel that finds a word locked
 * for long is left to a further pass; after a pass no word is locked, so as many as there are words on its
 * way are always enough. Source: Yalciner 2016, section 4.5 (full atomic reconstruction). There the mean is
 * kept in 8 bits and replaced by compare and swap; sums lose nothing and need no loop. */
#include "systems/svo/internal.h"

static void fill(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t slots = scene->pages[KD_LAYER_DYNAMIC].page_count * KD_PAGE_SEGMENTS;
    uint32_t again[4] = {svo->dynamic_room, 1, slots, 0};
    svo_add_taken(gpu, state, svo, scene);
    /* A voxel can lose once a pass, and each time at another word: the dense cell's, a node's, the leaf's. */
    for (uint32_t i = 0; i < svo_levels(svo) + 1; i++) {
        svo_args(gpu, state, svo, KD_COUNT_LEFT, 1, slots * (KD_SEGMENT_VOXELS / 2), KD_ARGS_LIST);
        kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
        kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_LEFT * 4, 4, 0);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
        svo_bind_taken(gpu, svo, scene);
        kd_gpu_bind_uniform(gpu, 0, again, sizeof again);
        kd_gpu_dispatch_indirect(gpu, state->programs[SVO_TAKEN_ADD], svo->counters, KD_ARGS_LIST * 4);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
}

void svo_build_atomic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    svo_build_taken(gpu, state, svo, scene, fill);
}
