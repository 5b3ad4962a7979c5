#ifndef KD_SYSTEMS_VOXEL_PAGES_PLACEMENT_H
#define KD_SYSTEMS_VOXEL_PAGES_PLACEMENT_H

#include "components/voxel_scene.h"

/** Place the cascades round `focus`, concentric, snapped to the dense cells of the outermost, kept inside the
 * bounds of what there is to see where it is smaller or larger than the finest cascade. Sets moved. Space
 * world, metres Source  Yalciner 2016, section 4.3 and 4.9 (snapping) */
void placement_update(kd_voxel_scene *scene, kd_vec3 focus, kd_vec3 bounds_min, kd_vec3 bounds_max);

/** Tell where the cascades would stand for a focus: their low corners in cells from the world's origin. */
void placement_cells(const kd_voxel_scene *scene, kd_vec3 focus, kd_vec3 bounds_min, kd_vec3 bounds_max,
                     int32_t cells[KD_MAX_CASCADES][3]);

/** Tell whether a box would take part in cascade c while the cascades stand at `cells`. */
bool placement_would_include(const kd_voxel_scene *scene, int32_t cells[][3], uint32_t c, kd_vec3 low,
                             kd_vec3 high);

/** Tell whether a box takes part in cascade c: it touches it and is not wholly inside the next finer one. */
bool placement_includes(const kd_voxel_scene *scene, uint32_t c, kd_vec3 low, kd_vec3 high);

/** Tell whether it took part where the cascades stood in the frame before; false in the first. */
bool placement_included(const kd_voxel_scene *scene, uint32_t c, kd_vec3 low, kd_vec3 high);

#endif
