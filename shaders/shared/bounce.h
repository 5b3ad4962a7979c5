#ifndef KD_SHADERS_BOUNCE_H
#define KD_SHADERS_BOUNCE_H

#include "shaders/shared/gather.h"
#include "shaders/shared/layout.h"

/* Light that arrives at the dense cells of the octree from the scene and the sky, kept from frame to frame,
 * so that leaves can send it out again: every frame adds a bounce.
 *
 * Buffer "bounce": KD_BOUNCE_WORDS words a dense cell of every cascade, at the cell's place in the world
 * modulo 64, so that entries stay where they are while the cascades move. 0-5  irradiance / pi on surfaces
 * that face +x -x +y -y +z -z, in stored units (kd_tree_params.light.y), rgb9e5 6    frame in which it was
 * gathered 7    which of the cells that share the place: 8 bits of each coordinate over 64 | power of two of
 * the stored unit, 8 bits */
#define KD_BOUNCE_WORDS 8u
#define KD_BOUNCE_CONES 4

/* Uniform block KD_BIND_PASS of select.comp and gather.comp. */
struct kd_bounce_params {
    uvec4 work;  /* x: words of the dense level's mask, y: the first, zw: 0 */
    uvec4 frame; /* x: frame, y: frames in which every cell has its turn (a power of two), z: age from which
                    light is dropped, w: 0 */
    vec4 cone;   /* x: tan(aperture/2), y: step in diameters, z: largest distance m, w: radiance of the sky,
                    stored units */
    vec4 far;    /* x: width of far cones, of the opening, yzw: 0 */
    /* ---- 64 */
    vec4 cones[KD_BOUNCE_CONES * KD_CONE_SETS]; /* xyz: direction round +Z, w: weight; those of a set add up to 1 */
    /* ---- 320 */
};
KD_LAYOUT_CHECK(kd_bounce_params, 320)

#include "shaders/shared/layout_end.h"

#endif
