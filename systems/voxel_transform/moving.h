#ifndef KD_SYSTEMS_VOXEL_TRANSFORM_MOVING_H
#define KD_SYSTEMS_VOXEL_TRANSFORM_MOVING_H

/* The dynamic layer: its groups of voxels are listed by the kind of their objects, and each kind has its own
 * program. */

#include "components/pose_access.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/ecs/system.h"

typedef struct moving_voxels {
    kd_gpu_program list, list_args;
    kd_gpu_program programs[2][KD_MOVING_KINDS]; /* without and with marks in the mask; by KD_VOXEL_* */
    kd_gpu_buffer work, records;
    kd_texel_view record_view, shape_view, object_view, color_view;
    kd_pose_access pose;
} moving_voxels;

kd_status moving_init(kd_gpu *gpu, moving_voxels *m);
void moving_fini(kd_gpu *gpu, moving_voxels *m);

/** Give back the lists: nothing moves. */
void moving_rest(kd_gpu *gpu, moving_voxels *m);

/** Bring the layer's voxels to the world. Errors NO_MEMORY for the lists; nothing is done then */
kd_status moving_transform(kd_system_context *context, moving_voxels *m, const kd_voxel_scene *scene,
                           const kd_svo *svo);

#endif
