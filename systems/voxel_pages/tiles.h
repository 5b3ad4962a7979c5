#ifndef KD_SYSTEMS_VOXEL_PAGES_TILES_H
#define KD_SYSTEMS_VOXEL_PAGES_TILES_H

#include "systems/voxel_pages/objects.h"

/** Bits of the cascades in which a primitive is voxelized whole; in the others it is cut into tiles. */
uint32_t tiles_whole(const kd_voxel_scene *scene, const voxel_sight *sight);

/** Enter the tiles that stand in a cascade now, of every object seen that is cut into tiles. Errors
 * KD_NO_MEMORY */
kd_status tiles_see(voxel_objects *table, kd_voxel_scene *scene);

#endif
