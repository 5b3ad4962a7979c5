#ifndef KD_SHADERS_DEBUG_VIEW_H
#define KD_SHADERS_DEBUG_VIEW_H

#include "shaders/shared/layout.h"

/* What views of voxels show of them: the numbers of kd_view_channel but for its first. */
#define KD_SHOW_RADIANCE     1u
#define KD_SHOW_VOXEL_ALBEDO 2u
#define KD_SHOW_VOXEL_NORMAL 3u
#define KD_SHOW_OPACITY      4u
#define KD_SHOW_CASCADE      5u

/* Uniform block KD_BIND_PASS of these views. */
struct kd_debug_view_params {
    uvec4 view; /* xy: picture, z: level, w: channel */
    /* ---- 16 */
    uvec4 tree; /* x: 0, y: dynamic cells in use, z: nodes a level, w: level of the leaf
                   parents, from the dense one */
    /* ---- 32 */
};
KD_LAYOUT_CHECK(kd_debug_view_params, 32)

/* Follows in the block while voxels are drawn. */
struct kd_voxel_view_params {
    uvec4 source; /* x: number of the first voxel, y: segment slots, z: 0 depths are kept, 1 numbers, w: 1
                     draws what was listed */
    /* ---- 16 */
};
KD_LAYOUT_CHECK(kd_voxel_view_params, 16)
#define KD_VIEW_DYNAMIC 0x80000000u /* number of the first voxel of the dynamic layer */

/* Sums of attributes over the leaves below a cell, fixed point: 0 weight, 1-3 albedo, 4-6 normal (signed), 7
 * unused. First the nodes of sparse levels 1 and up by number, then the dense cells of the cascades, then the
 * levels above. */
#define KD_MEAN_WORDS  8u
#define KD_MEAN_ABOVE  37448u /* cells of all levels above the outermost cascade: 32^3 … 2^3 */
#define KD_MEAN_ONE    1023.0
#define KD_MEAN_WEIGHT 15.0 /* of eight covered leaves: a cell may hold 280 000 times as many */

#include "shaders/shared/layout_end.h"

#endif
