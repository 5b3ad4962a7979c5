#ifndef KD_SHADERS_SKY_H
#define KD_SHADERS_SKY_H

#include "shaders/shared/layout.h"

/* What surrounds the scene, uniform block KD_BIND_SKY: a uniform radiance and a map on top of it. */
struct kd_sky_params {
    vec4 ambient;   /* rgb: radiance from everywhere; w 0 */
    /* ---- 16 */
    vec4 to_map[3]; /* rows: from the world's directions to the map's; w of the first: factor on the map */
    /* ---- 64 */
};
KD_LAYOUT_CHECK(kd_sky_params, 64)

/* Means of the map over discs, octahedral, KD_SKY_EDGE texels square with their outer ones on the square's border.
 * Layer l has discs whose half angle has the tangent KD_SKY_TANGENT * 2^l. */
#define KD_SKY_EDGE 64
#define KD_SKY_LAYERS 7
#define KD_SKY_TANGENT 0.03

#include "shaders/shared/layout_end.h"

#endif
