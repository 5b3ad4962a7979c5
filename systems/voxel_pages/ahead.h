#ifndef KD_SYSTEMS_VOXEL_PAGES_AHEAD_H
#define KD_SYSTEMS_VOXEL_PAGES_AHEAD_H

#include "systems/voxel_pages/objects.h"

/** Ask for the caches of objects that will come to a cascade soon, if the focus goes on as it did since the
 * last call. The cascades are kept inside of `low` … `high` as placement_update keeps them. Changes no
 * picture: what is not ready when it is needed is made then. Errors KD_NO_MEMORY */
kd_status ahead_want(voxel_objects *table, kd_voxel_scene *scene, kd_vec3 focus, kd_vec3 low, kd_vec3 high);

#endif
