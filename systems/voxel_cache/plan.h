#ifndef KD_SYSTEMS_VOXEL_CACHE_PLAN_H
#define KD_SYSTEMS_VOXEL_CACHE_PLAN_H

#include "components/voxel_scene.h"

/* Which caches are made in this frame. */
typedef struct plan_item {
    uint32_t cache; /* kd_voxel_scene.caches */
    uint32_t due;   /* frames until it is needed; 0: now */
    float work;     /* estimated, in columns: kd_voxel_cache.work */
} plan_item;

typedef struct voxel_plan {
    plan_item *items; /* [count], those that are needed first before others */
    uint32_t count, capacity;
} voxel_plan;

/** Choose: all that is needed now, and of what is needed later as much as brings all of it in time at an even
 * rate. Counts work, no time: the same calls choose the same. Errors KD_NO_MEMORY; nothing is chosen */
kd_status plan_choose(voxel_plan *plan, kd_voxel_scene *scene);

void plan_fini(voxel_plan *plan);

#endif
