#ifndef KD_SYSTEMS_VOXEL_CACHE_DISTANCE_H
#define KD_SYSTEMS_VOXEL_CACHE_DISTANCE_H

#include "components/voxel_scene.h"
#include "runtime/asset/model.h"

/* Sums of distances between voxels and the mesh they stand for, in edges of a voxel. */
typedef struct voxel_distances {
    double to_mesh;   /* of all voxels' centres to the surface */
    double to_voxels; /* of all vertices to the nearest centre */
    uint64_t voxels, vertices;
} voxel_distances;

/** Add how far the voxels of a chunk are from their primitive, and its vertices from them. Both are looked
 * for within three cells.
 *
 *  shape   [chunk->count][2] cached words (shaders/shared/voxel.h), of all that the primitive has: one chunk
 *  Errors  KD_NO_MEMORY
 *  Source  Gaitatzes & Papaioannou 2012, "Progressive Screen-Space Multichannel Surface Voxelization",
 * table 6.2: the mean of one-sided distances; their figures for voxels of the mesh itself are those of
 * `to_mesh`
 */
kd_status voxel_distances_add(const kd_primitive_desc *primitive, const kd_voxel_chunk *chunk,
                              const uint32_t (*shape)[2], voxel_distances *sum);

#endif
