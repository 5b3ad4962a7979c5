#ifndef KD_SHADERS_EMITTERS_H
#define KD_SHADERS_EMITTERS_H

#include "shaders/shared/layout.h"

/* Things that glow, as few lights: voxels with emission are joined by blocks of a fixed lattice, and every
 * block that holds some is an emitter. Wide cones smear what is small and bright; narrow ones are traced
 * towards emitters instead. */
#define KD_MAX_EMITTERS 64

/* Sums a block, in integers so that order does not matter: 0-2 area times emission, 3-5 place in cells from
 * the block's low corner, 6-8 its squares, 9-11 normal (signed), 12 double sided, 13 weight of 3 to 12, 14 area. */
#define KD_EMITTER_WORDS 16u
/* A block of the finest lattice has 4 dense cells an edge, so a cascade has 16. */
#define KD_EMITTER_BLOCK_LOG2 2
#define KD_EMITTER_BLOCKS 16
/* Area is counted in these parts of a cell's face, emission in these of the scene's brightest. */
#define KD_EMITTER_AREA_ONE 64.0
#define KD_EMITTER_RADIANCE_ONE 1023.0

struct kd_emitter {
    vec4 place;  /* xyz: middle ws, w: radius of what glows m */
    /* ---- 16 */
    vec4 normal; /* xyz: mean normal ws, shorter than 1 where it glows in several directions, w: share of double-sided surface */
    /* ---- 32 */
    vec4 power;  /* rgb: radiance times area W/sr, w: area m^2 */
    /* ---- 48 */
};
KD_LAYOUT_CHECK(kd_emitter, 48)

struct kd_emitters_params {
    uvec4 info;  /* x: emitters; 0: emission lights by cones */
    KD_STRUCT kd_emitter emitter[KD_MAX_EMITTERS];
};
KD_LAYOUT_CHECK(kd_emitters_params, 16 + 48 * KD_MAX_EMITTERS)

#include "shaders/shared/layout_end.h"

#endif
