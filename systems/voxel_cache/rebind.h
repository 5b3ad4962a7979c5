#ifndef KD_SYSTEMS_VOXEL_CACHE_REBIND_H
#define KD_SYSTEMS_VOXEL_CACHE_REBIND_H

#include "components/scene_store.h"
#include "components/voxel_scene.h"

/** Bind a skinned cache's voxels by the way through the body to the skin's bones (geodesic.h) instead of by
 * the nearest surface. Reads back and writes the cache buffers.
 *
 *  chunks  [count], of the cache
 *  told    set when a mesh was found that encloses nothing and keeps its bindings; one message says so
 *  Errors  KD_NO_MEMORY
 */
kd_status rebind_geodesic(kd_gpu *gpu, const kd_scene_store *store, const kd_voxel_scene *scene,
                          const kd_voxel_cache *cache, const kd_voxel_chunk *chunks, uint32_t count,
                          bool *told);

/** Mix what rebind_geodesic looks at, besides the primitive itself, into a hash: the skin in its bind pose
 * and the whole mesh. Errors KD_NO_MEMORY */
kd_status rebind_hash(const kd_scene_store *store, uint32_t primitive, uint64_t *hash);

#endif
