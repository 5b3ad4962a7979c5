#ifndef KD_COMPONENTS_POSE_ACCESS_H
#define KD_COMPONENTS_POSE_ACCESS_H

#include "components/deform.h"
#include "components/scene_store.h"

/* A buffer as texels, which software drivers read several times faster than storage. */
typedef struct kd_texel_view {
    kd_gpu_texture texture;
    uint32_t viewed; /* the buffer it was made of */
} kd_texel_view;

/** Bind a view of the buffer, made anew where that has grown. Threading: GPU lane */
void kd_texel_view_bind(kd_gpu *gpu, kd_texel_view *view, uint32_t unit, kd_gpu_buffer buffer,
                        kd_texture_format format);
void kd_texel_view_fini(kd_gpu *gpu, kd_texel_view *view);

/* What a program that poses voxels (shaders/include/voxel_pose.glsl) reads besides caches and objects: joint
 * matrices, deformed vertices, indices and the voxels' bindings, on units 0 to 3. */
#define KD_POSE_VIEWS 4
typedef struct kd_pose_access {
    kd_texel_view views[KD_POSE_VIEWS];
    kd_gpu_buffer none; /* stands in for buffers that a scene has no need of */
} kd_pose_access;

kd_status kd_pose_access_init(kd_gpu *gpu, kd_pose_access *access);
/** Bind the views. `binding`: of the voxel caches. Threading: GPU lane */
void kd_pose_access_bind(kd_gpu *gpu, kd_pose_access *access, const kd_scene_store *store,
                         const kd_joint_palette *palette, kd_gpu_buffer binding);
/** The buffer, or one that stands in for it. */
kd_gpu_buffer kd_pose_access_or_none(const kd_pose_access *access, kd_gpu_buffer buffer);
void kd_pose_access_fini(kd_gpu *gpu, kd_pose_access *access);

#endif
