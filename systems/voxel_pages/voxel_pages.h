#ifndef KD_SYSTEMS_VOXEL_PAGES_VOXEL_PAGES_H
#define KD_SYSTEMS_VOXEL_PAGES_VOXEL_PAGES_H

#include "runtime/ecs/system.h"

/** Register systems voxel_objects (CPU: cascades, objects, layers, caches wanted) — before voxel_cache. */
kd_status kd_voxel_objects_import(kd_schedule *s);

/** Register system voxel_pages (GPU: segments in and out of the pages) — after voxel_cache. */
kd_status kd_voxel_pages_import(kd_schedule *s);

#endif
