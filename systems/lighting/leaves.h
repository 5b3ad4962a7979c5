#ifndef KD_SYSTEMS_LIGHTING_LEAVES_H
#define KD_SYSTEMS_LIGHTING_LEAVES_H

#include "components/svo.h"

/** Bind what passes over all leaves read: the tree's parameters, its book, and the cells of both layers
 * (shaders/include/cell_load.glsl). Threading: GPU lane */
void lighting_bind_leaves(kd_gpu *gpu, const kd_svo *svo);

#endif
