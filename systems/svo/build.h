#ifndef KD_SYSTEMS_SVO_BUILD_H
#define KD_SYSTEMS_SVO_BUILD_H

#include "systems/svo/internal.h"

/** Number the occupied cells of a layer and add up their attributes. Source: this project, see build.c */
void build_layer(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene, kd_voxel_layer layer);

/** Join the layers and build levels, lists and the node table. */
void build_tree(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);

#endif
