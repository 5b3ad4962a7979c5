#ifndef KD_SHADERS_GATHER_H
#define KD_SHADERS_GATHER_H

#include "shaders/shared/layout.h"

#define KD_MAX_CONES 16
#define KD_GATHER_ROUGH 0.7 /* from this roughness on reflections are the diffuse cones' */

/* Parameters of the cone tracer, uniform block KD_BIND_PASS. */
struct kd_gather_params {
    uvec4 size;      /* xy: picture, z: every n-th pixel is traced, w: cones */
    vec4 cone;       /* x: tan(aperture/2), y: step in diameters, z: largest distance m, w: start in voxels */
    vec4 light;      /* x: intensity, y: AO falloff 1/m, z: AO intensity, w 0 */
    uvec4 flags;     /* x: 1 traces glossy cones, y: texels of the guide a traced pixel */
    vec4 refine;     /* x: relative difference of neighbours from which pixels between them are traced */
    vec4 cone_turn;  /* x: angle between the cones of neighbouring pixels, y: difference of their height over the surface */
    /* ---- 96 */
    vec4 cones[KD_MAX_CONES]; /* xyz: direction round +Z, w: weight; weights add up to 1 */
    /* ---- 352 */
};
KD_LAYOUT_CHECK(kd_gather_params, 352)

/* Counters of samples, where they are wanted; after them the samples of each pixel of the picture, a word each.
 *   0 traced pixels, 1 most samples of a pixel, 2-3 unused, then KD_CONE_WORDS words a cone, the glossy one and those to emitters last:
 *   0 times traced, 1 samples, 2 most samples, 3 unused */
#define KD_CONE_HEAD 4u
#define KD_CONE_WORDS 4u
#define KD_CONE_COUNTERS (KD_CONE_HEAD + KD_CONE_WORDS * (KD_MAX_CONES + 2u))

#include "shaders/shared/layout_end.h"

#endif
