#ifndef KD_SHADERS_BLEND_H
#define KD_SHADERS_BLEND_H

#include "shaders/shared/layout.h"

/* How blended surfaces gather light, uniform block KD_BIND_PASS. */
struct kd_blend_params {
    vec4 cone;  /* x: tan(aperture / 2), y: step in diameters, z: largest distance m, w: start in voxels */
    vec4 light; /* x: intensity, y: AO falloff 1/m, z: AO intensity, w: width of far cones, of the opening */
    /* ---- 32 */
};
KD_LAYOUT_CHECK(kd_blend_params, 32)

#include "shaders/shared/layout_end.h"

#endif
