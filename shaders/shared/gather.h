#ifndef KD_SHADERS_GATHER_H
#define KD_SHADERS_GATHER_H

#include "shaders/shared/layout.h"

#define KD_MAX_CONES 16

/* Parameters of the cone tracer, uniform block KD_BIND_PASS. */
struct kd_gather_params {
    uvec4 size;      /* xy: picture, z: every n-th pixel is traced, w: cones */
    vec4 cone;       /* x: tan(aperture/2), y: step in diameters, z: largest distance m, w: start in voxels */
    vec4 light;      /* x: intensity, y: AO falloff 1/m, z: AO intensity, w: radiance of the sky */
    uvec4 flags;     /* x: 1 traces glossy cones */
    vec4 cone_turn;  /* x: angle between the cones of neighbouring pixels, y: difference of their height over the surface */
    /* ---- 80 */
    vec4 cones[KD_MAX_CONES]; /* xyz: direction round +Z, w: weight; weights add up to 1 */
    /* ---- 336 */
};
KD_LAYOUT_CHECK(kd_gather_params, 336)

#include "shaders/shared/layout_end.h"

#endif
