#ifndef KD_SYSTEMS_SVO_INTERNAL_H
#define KD_SYSTEMS_SVO_INTERNAL_H

#include "components/render_targets.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/ecs/system.h"
#include "runtime/gpu/rank.h"

/* Shared by the systems of this folder: programs and what is known of the counts. */
typedef struct svo_state {
    kd_gpu_program accumulate, pack, merge, reduce, args, list, list_dense, nodes;
    kd_gpu_program filter_sparse, filter_dense, filter_up, clear_dense;
    kd_gpu_rank rank;
    kd_gpu_readback readback;  /* counters of the frames before, without a stall */
    uint32_t texel_viewed[4];  /* buffers behind kd_tree's texel views */
    uint64_t bytes_build;
} svo_state;

/** Make what does not depend on counts: masks, ranks, atlas, uniform. Errors KD_GPU, KD_NO_MEMORY */
kd_status svo_make(kd_gpu *gpu, kd_svo *svo, const kd_voxel_scene *scene);
void svo_destroy(kd_gpu *gpu, kd_svo *svo);

/** Make room for so many nodes a level. Errors KD_GPU, KD_NO_MEMORY */
kd_status svo_reserve_nodes(kd_gpu *gpu, kd_svo *svo, uint32_t nodes);

/** Make room for so many cells of a layer. */
kd_status svo_reserve_cells(kd_gpu *gpu, kd_svo *svo, kd_voxel_layer layer, uint32_t cells);

/** Write the uniform block for where the cascades stand now. */
void svo_write_params(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene);

/** Hand what the tracer reads to kd_tree. */
void svo_publish(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene, kd_tree *tree);

/* Filter: shaders/svo/filter_*.comp */
void svo_filter(kd_gpu *gpu, svo_state *state, const kd_svo *svo);

#endif
