#ifndef KD_SHADERS_JUMP_H
#define KD_SHADERS_JUMP_H

#include "shaders/shared/layout.h"

/* Buffer "light.jump": has the light in the scene changed so much that what was gathered in frames before is
 * of no use? Light of the octree on a coarse level, and that of emitters, are compared with the last frame's.
 *   0      1: it has, in this frame
 *   1      change of light since the last frame, in millionths of all of it
 *   2-5    emitters' luminance in all; their middle
 *   6-8    low corner of the outermost cascade in cells
 *   9 …    light of each cell of the coarse level, as floats */
#define KD_JUMP_NOW 0
#define KD_JUMP_MEASURE 1
#define KD_JUMP_EMITTERS 2
#define KD_JUMP_ORIGIN 6
#define KD_JUMP_CELLS 9
#define KD_JUMP_LEVEL 2 /* above the outermost cascade: 16 cells an edge */
#define KD_JUMP_EDGE 16
#define KD_JUMP_WORDS (KD_JUMP_CELLS + KD_JUMP_EDGE * KD_JUMP_EDGE * KD_JUMP_EDGE)

#include "shaders/shared/layout_end.h"

#endif
