#ifndef KD_SYSTEMS_VOXEL_CACHE_MAKER_H
#define KD_SYSTEMS_VOXEL_CACHE_MAKER_H

#include "runtime/asset/voxel_file.h"
#include "systems/voxel_cache/load.h"
#include "systems/voxel_cache/voxelizer.h"

/* Makes whole caches: cuts them into chunks, keeps the list of chunks. */
typedef struct cache_maker {
    voxelizer voxelizer;
    kd_voxel_chunk *chunks; /* of the cache in work */
    uint32_t count, capacity;
    uint32_t chunk_capacity; /* of kd_voxel_scene.chunks */
    bool told;               /* that a mesh could not be bound as was asked for */
} cache_maker;

kd_status maker_init(kd_gpu *gpu, cache_maker *maker);
void maker_fini(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene);

/** Voxelize a cache's primitive and enter its chunks into the scene. It counts as made whatever happens;
 * parts that could not be made are left out. Errors as voxelizer_run */
kd_status maker_make(kd_gpu *gpu, cache_maker *maker, const kd_scene_store *store, kd_voxel_scene *scene,
                     kd_voxel_cache *cache);

/** Take a cache's voxels from a level that was read whole. Errors as voxelizer_run */
kd_status maker_load(kd_gpu *gpu, cache_maker *maker, kd_voxel_scene *scene, const voxel_load *load,
                     kd_voxel_cache *cache);

/** Read a cache's voxels back and add them to a file as a level. Waits for the GPU. Errors KD_NO_MEMORY */
kd_status maker_write(kd_gpu *gpu, const kd_voxel_scene *scene, const kd_voxel_cache *cache,
                      kd_voxel_level level, kd_voxel_writer *writer);

#endif
