#ifndef KD_SYSTEMS_VOXEL_CACHE_REFERENCE_H
#define KD_SYSTEMS_VOXEL_CACHE_REFERENCE_H

#include <stdbool.h>

/** Tell whether a triangle touches a box, by all thirteen separating axes, in double precision. Boxes that
 * only touch the triangle count.
 *
 *  Shapes  triangle[corner][axis]; the box is [low, high] on every axis
 *  Source  Akenine-Moeller 2001, "Fast 3D triangle-box overlap testing"
 */
bool voxel_reference_touches(const double triangle[3][3], const double low[3], const double high[3]);

#endif
