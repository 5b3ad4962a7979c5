#ifndef KD_SYSTEMS_VOXEL_PAGES_OBJECT_PARAMS_H
#define KD_SYSTEMS_VOXEL_PAGES_OBJECT_PARAMS_H

#include "components/scene_store.h"
#include "systems/voxel_pages/stale.h"

/* What the shaders are told of every object: its place, its normals' place, its kind and what it emits. */
typedef struct object_params {
    struct kd_voxel_object_params *rows; /* as they are on the GPU */
    uint32_t capacity;
} object_params;

/** The rows from the first to the last that changed go to scene->object_params. Where a static object's
 * emission changed its place is stale. */
void object_params_upload(object_params *params, kd_gpu *gpu, const kd_scene_store *store,
                          kd_voxel_scene *scene, stale_parts *stale);

void object_params_fini(object_params *params);

#endif
