#ifndef KD_SHADERS_DEFORM_H
#define KD_SHADERS_DEFORM_H

#include "shaders/shared/layout.h"

/* Work of the deform pass: one item for each deforming primitive of each instance, and one pair of words for
 * each work group that says which vertices of which item it takes. */
#define KD_DEFORM_GROUP 64u         /* vertices a work group takes */
#define KD_DEFORM_ROW   32768u      /* work groups along x; more go to further rows */
#define KD_DEFORM_NONE  0xffffffffu /* no skin, no morph targets */

struct kd_deform_item {
    uvec4 range; /* x: first vertex at rest, y: the instance's first, z: vertex count, w: first skin vertex */
    /* ---- 16 */
    uvec4 morph; /* x: first morph vertex, y: word at which the weights start, z: weights, w: 0 */
    /* ---- 32 */
    uvec4 skin; /* x: first matrix of the palette, y: joints, zw: 0 */
    /* ---- 48 */
};
KD_LAYOUT_CHECK(kd_deform_item, 48)

/* Words: two a work group (item, first vertex), then two a weight that is not zero (target, float bits) */
struct kd_deform_params {
    uvec4 count; /* x: work groups */
    /* ---- 16 */
};
KD_LAYOUT_CHECK(kd_deform_params, 16)

/* Work of the subdivide pass, which follows: limit points from the posed cages, a pair of words a work group as above
 * (item, first row). */
struct kd_subdivide_item {
    uvec4 range; /* x: first vertex at rest, y: the instance's first, z: vertices, w: first row */
    /* ---- 16 */
    uvec4 cage; /* x: first vertex of the instance's cage; yzw 0 */
    /* ---- 32 */
};
KD_LAYOUT_CHECK(kd_subdivide_item, 32)

struct kd_stencil_row_words {
    KD_UINT first, count; /* stencils */
    float tangent_u, tangent_v;
    /* ---- 16 */
};
KD_LAYOUT_CHECK(kd_stencil_row_words, 16)

struct kd_stencil_words {
    KD_UINT vertex; /* of the cage */
    float weight, du, dv;
    /* ---- 16 */
};
KD_LAYOUT_CHECK(kd_stencil_words, 16)

/* storage bindings */
#define KD_DEFORM_GEOMETRY 0
#define KD_DEFORM_SKINS    1
#define KD_DEFORM_MORPHS   2
#define KD_DEFORM_JOINTS   3
#define KD_DEFORM_ITEMS    4
#define KD_DEFORM_WORDS    5
#define KD_SUBDIVIDE_ROWS     1
#define KD_SUBDIVIDE_STENCILS 2

#include "shaders/shared/layout_end.h"

#endif
