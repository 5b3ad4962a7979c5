#ifndef KD_SYSTEMS_VOXEL_PAGES_TILES_H
#define KD_SYSTEMS_VOXEL_PAGES_TILES_H

#include "systems/voxel_pages/objects.h"

/** Bits of the cascades in which a primitive is voxelized whole; in the others it is cut into tiles. */
uint32_t tiles_whole(const kd_voxel_scene *scene, const voxel_sight *sight);

/** Called with what a tile is where the cascades stand, and its cascade. */
typedef kd_status tile_fn(void *user, const voxel_sight *tile, uint32_t c);

/** Visit the tiles that an object has where the cascades stand at `cells`; none when it is whole everywhere.
 */
kd_status tiles_visit(const kd_voxel_scene *scene, const kd_voxel_object *object,
                      int32_t cells[KD_MAX_CASCADES][3], tile_fn *fn, void *user);

/** Enter the tiles that stand in a cascade now, of every object seen that is cut into tiles. Errors
 * KD_NO_MEMORY */
kd_status tiles_see(voxel_objects *table, kd_voxel_scene *scene);

#endif
