#ifndef KD_SYSTEMS_VOXEL_CACHE_VOXELIZER_H
#define KD_SYSTEMS_VOXEL_CACHE_VOXELIZER_H

#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/gpu/rank.h"

/* Programs and scratch of the voxelizer. */
typedef struct voxelizer {
    kd_gpu_program mark, accumulate, pack, bind;
    kd_gpu_program accumulate_glowing; /* measures areas too; made when first needed */
    kd_gpu_rank rank;
    kd_gpu_buffer mask, ranks, sums, nearest, columns, counter;
} voxelizer;

/** Get how a cache is made, KD_VOXEL_LEVEL_*. */
uint32_t voxelizer_flags(const kd_voxel_scene *scene, const kd_voxel_cache *cache);

kd_status voxelizer_init(kd_gpu *gpu, voxelizer *v);
void voxelizer_fini(kd_gpu *gpu, voxelizer *v);

/** Free the buffers that only work in progress needs. */
void voxelizer_rest(kd_gpu *gpu, voxelizer *v);

/** Take places for voxels and bindings (0: rigid) in the cache buffers, which grow as needed; sets the
 * chunk's count, first and first_binding. Errors as voxelizer_run */
kd_status voxelizer_take(kd_gpu *gpu, kd_voxel_scene *scene, uint32_t voxels, uint32_t bindings,
                         kd_voxel_chunk *chunk);

/** Voxelize one chunk of a cache entry into places of the cache buffers; fills count, first and
 * first_binding. Waits for the count: for loading, not for steady frames. Errors KD_GPU, KD_NO_MEMORY,
 * KD_TOO_LARGE when the cache buffers are full, KD_OUT_OF_RANGE when the chunk has more cells or voxels than
 * the largest buffers hold while it is made: cut it. Nothing is taken then */
kd_status voxelizer_run(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store, const kd_voxel_cache *cache,
                        kd_voxel_scene *scene, kd_voxel_chunk *chunk);

#endif
