#ifndef KD_SYSTEMS_VOXEL_CACHE_COLUMNS_H
#define KD_SYSTEMS_VOXEL_CACHE_COLUMNS_H

#include "components/voxel_scene.h"
#include "runtime/asset/model.h"

/* The work list of the voxelizer: which columns of cells lie under which triangle. One row a triangle, and
 * one more: first column | axis 2, low u 10, low v 10 bits | columns along u | creases. Bit i of the creases
 * says that the side from corner i to the next is one. See shaders/voxel_cache/triangle.glsl. */
typedef struct kd_columns {
    uint32_t (*rows)[4]; /* [triangles + 1], freed by the caller */
    uint32_t triangles;
    uint32_t columns;
} kd_columns;

/** List the columns of a primitive's triangles inside a chunk (origin, span and size are read); with
 * `creases` look for these too. Errors KD_NO_MEMORY, KD_TOO_LARGE above 2^31 columns. */
kd_status columns_list(const kd_primitive_desc *primitive, const kd_voxel_chunk *chunk, bool creases,
                       kd_columns *out);

/** Estimate how many columns all triangles of a cache's primitive have, or those that lie in its tile,
 * without listing them. */
float columns_estimate(const kd_primitive_desc *primitive, const kd_voxel_cache *cache);

#endif
