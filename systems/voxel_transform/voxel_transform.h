#ifndef KD_SYSTEMS_VOXEL_TRANSFORM_VOXEL_TRANSFORM_H
#define KD_SYSTEMS_VOXEL_TRANSFORM_VOXEL_TRANSFORM_H

#include "runtime/ecs/system.h"

/** Register system voxel_transform. */
kd_status kd_voxel_transform_import(kd_schedule *s);

#endif
