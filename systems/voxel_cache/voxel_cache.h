#ifndef KD_SYSTEMS_VOXEL_CACHE_VOXEL_CACHE_H
#define KD_SYSTEMS_VOXEL_CACHE_VOXEL_CACHE_H

#include "runtime/ecs/system.h"

kd_status kd_voxel_cache_import(kd_schedule *s);

#endif
