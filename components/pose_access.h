#ifndef KD_COMPONENTS_POSE_ACCESS_H
#define KD_COMPONENTS_POSE_ACCESS_H

#include "components/deform.h"
#include "components/scene_store.h"

/* What a program that poses voxels (shaders/include/voxel_pose.glsl) reads besides caches and objects: joint
 * matrices, deformed vertices and indices as texel buffers on units 0 to 2. */
typedef struct kd_pose_access {
    kd_gpu_texture views[3];
    uint32_t viewed[3]; /* the buffers they were made of */
    kd_gpu_buffer none; /* stands in for buffers that a scene has no need of */
} kd_pose_access;

kd_status kd_pose_access_init(kd_gpu *gpu, kd_pose_access *access);
/** Bind the views, made anew where a buffer has grown. Threading: GPU lane */
void kd_pose_access_bind(kd_gpu *gpu, kd_pose_access *access, const kd_scene_store *store,
                         const kd_joint_palette *palette);
/** The buffer, or one that stands in for it. */
kd_gpu_buffer kd_pose_access_or_none(const kd_pose_access *access, kd_gpu_buffer buffer);
void kd_pose_access_fini(kd_gpu *gpu, kd_pose_access *access);

#endif
