#ifndef KD_SYSTEMS_VOXEL_CACHE_KEY_H
#define KD_SYSTEMS_VOXEL_CACHE_KEY_H

#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "runtime/asset/voxel_file.h"

/* Hashes of what voxels are made of. Primitives and images are hashed once each. */
typedef struct voxel_keys {
    uint64_t program;              /* of the voxelizer's shaders */
    uint64_t *primitives, *images; /* 0: not hashed yet */
    uint32_t primitive_capacity, image_capacity;
} voxel_keys;

/** Hash the voxelizer. Errors KD_GPU when its shaders cannot be read. */
kd_status keys_init(voxel_keys *keys);
void keys_fini(voxel_keys *keys);

/** Hash all that decides a cache's voxels: mesh, what the material shows, span, lattice, kind, options and
 * the voxelizer. Returns false when memory is out. */
bool keys_of(voxel_keys *keys, const kd_scene_store *store, const kd_voxel_scene *scene,
             const kd_voxel_cache *cache, kd_voxel_key *out);

#endif
