#ifndef KD_SYSTEMS_VOXEL_CACHE_CREASES_H
#define KD_SYSTEMS_VOXEL_CACHE_CREASES_H

#include "systems/voxel_cache/columns.h"

/** Mark the sides of triangles with columns at which a surface ends or bends by more than an eighth of a half
 * turn. Sides meet where their ends lie in the same places, whatever the vertices are. Errors KD_NO_MEMORY */
kd_status creases_mark(const kd_primitive_desc *primitive, kd_columns *columns);

#endif
