#ifndef KD_SYSTEMS_VOXEL_CACHE_MAKER_H
#define KD_SYSTEMS_VOXEL_CACHE_MAKER_H

#include "systems/voxel_cache/voxelizer.h"

/* Makes whole caches: cuts them into chunks, keeps the list of chunks. */
typedef struct cache_maker {
    voxelizer voxelizer;
    kd_voxel_chunk *chunks; /* of the cache in work */
    uint32_t count, capacity;
    uint32_t chunk_capacity; /* of kd_voxel_scene.chunks */
} cache_maker;

kd_status maker_init(kd_gpu *gpu, cache_maker *maker);
void maker_fini(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene);

/** Voxelize a cache's primitive and enter its chunks into the scene. It counts as made whatever happens; parts that could
 *  not be made are left out. Errors as voxelizer_run */
kd_status maker_make(kd_gpu *gpu, cache_maker *maker, const kd_scene_store *store, kd_voxel_scene *scene,
                     kd_voxel_cache *cache);

#endif
