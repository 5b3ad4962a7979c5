#ifndef KD_COMPONENTS_RIGID_ACCESS_H
#define KD_COMPONENTS_RIGID_ACCESS_H

#include "components/pose_access.h"
#include "components/voxel_scene.h"

/* What a program that brings static voxels to the world (shaders/include/rigid_texels.glsl) reads: segments,
 * chunks and objects, on units 0 to 2. */
#define KD_RIGID_VIEWS 3
typedef struct kd_rigid_access {
    kd_texel_view views[KD_RIGID_VIEWS];
} kd_rigid_access;

/** Bind the views. Threading: GPU lane */
void kd_rigid_access_bind(kd_gpu *gpu, kd_rigid_access *access, const kd_voxel_scene *scene);
void kd_rigid_access_fini(kd_gpu *gpu, kd_rigid_access *access);

#endif
