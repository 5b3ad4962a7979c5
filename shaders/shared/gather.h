#ifndef KD_SHADERS_GATHER_H
#define KD_SHADERS_GATHER_H

#include "shaders/shared/layout.h"

#define KD_MAX_CONES 16
#define KD_CONE_SETS 4 /* of neighbours, components/cone_set.h */
#define KD_GATHER_ROUGH 0.7 /* from this roughness on reflections are the diffuse cones' */

/* Parameters of the cone tracer, uniform block KD_BIND_PASS. */
struct kd_gather_params {
    uvec4 size;      /* xy: picture, z: every n-th pixel is traced, w: cones */
    vec4 cone;       /* x: tan(aperture/2), y: step in diameters, z: largest distance m, w: start in voxels */
    vec4 light;      /* x: intensity, y: AO falloff 1/m, z: AO intensity, w: width of far cones, of the opening */
    uvec4 flags;     /* x: 1 traces glossy cones, y: texels of the guide a traced pixel, z: kd_cones_interpolation, as compiled */
    vec4 refine;     /* x: relative difference of neighbours from which pixels between them are traced, y: factor
                        on light while it is kept, a power of two */
    /* ---- 80 */
    vec4 cones[KD_MAX_CONES * KD_CONE_SETS]; /* xyz: direction round +Z, w: weight; those of a set add up to 1 */
    /* ---- 1104 */
    uvec4 reuse;       /* x: frames between which a pixel is traced, 0: light of the frame before is of no use, y: frame */
    mat4 before;       /* view and projection of the frame before */
    vec4 before_eye;   /* viewing depth then: dot(xyz, place) + w */
    /* ---- 1200 */
};
KD_LAYOUT_CHECK(kd_gather_params, 1200)

/* What alpha of a traced pixel's reflection says: how it was made, plus KD_TRACED_AGE for every frame since. */
#define KD_TRACED_NOT 0.0    /* interpolated */
#define KD_TRACED_ROUGH 1.0  /* its reflection is the diffuse light, once that is smoothed */
#define KD_TRACED_GLOSSY 2.0
#define KD_TRACED_AGE 0.125

/* Counters of samples, where they are wanted; after them the samples of each pixel of the picture, a word each.
 *   0 traced pixels, 1 most samples of a pixel, 2-3 unused, then KD_CONE_WORDS words a cone, the glossy one and those to emitters last:
 *   0 times traced, 1 samples, 2 most samples, 3 unused */
#define KD_CONE_HEAD 4u
#define KD_CONE_WORDS 4u
#define KD_CONE_COUNTERS (KD_CONE_HEAD + KD_CONE_WORDS * (KD_MAX_CONES + 2u))

#include "shaders/shared/layout_end.h"

#endif
