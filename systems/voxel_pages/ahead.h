#ifndef KD_SYSTEMS_VOXEL_PAGES_AHEAD_H
#define KD_SYSTEMS_VOXEL_PAGES_AHEAD_H

#include "runtime/core/box_tree.h"
#include "systems/voxel_pages/objects.h"

/** Note the focus of this frame: how it moves since the last call says what is looked for. */
void ahead_begin(voxel_objects *table, const kd_voxel_scene *scene, kd_vec3 focus);

/** The way that the cascades may go in the frames that are looked ahead. Space world, metres */
kd_vec3 ahead_way(const voxel_objects *table);

/** Ask for the caches of objects that will come to a cascade soon, if the focus goes on as it did since the
 * last call. The cascades are kept inside of `bounds` as placement_update keeps them. Changes no
 * picture: what is not ready when it is needed is made then. Errors KD_NO_MEMORY */
kd_status ahead_want(voxel_objects *table, kd_voxel_scene *scene, const kd_box *bounds);

#endif
