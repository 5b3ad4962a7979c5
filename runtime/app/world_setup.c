#include "runtime/app/world_setup.h"

#include "systems/animation/animation.h"
#include "systems/bounce/bounce.h"
#include "systems/cone_trace/cone_trace.h"
#include "systems/debug_view/debug_view.h"
#include "systems/deferred/deferred.h"
#include "systems/deform/deform.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/lighting/lighting.h"
#include "systems/resolve/resolve.h"
#include "systems/scene/scene.h"
#include "systems/shadow/shadow.h"
#include "systems/svo/svo.h"
#include "systems/voxel_cache/voxel_cache.h"
#include "systems/voxel_pages/voxel_pages.h"
#include "systems/voxel_transform/voxel_transform.h"

typedef kd_status import(kd_schedule *s);

static kd_status import_all(kd_schedule *s, import *const *imports, size_t count)
{
    kd_status status = KD_OK;
    for (size_t i = 0; i < count && status == KD_OK; i++)
        status = imports[i](s);
    return status;
}

kd_status app_import_systems(kd_schedule *s)
{
    static import *const imports[] = {
        kd_scene_import,    kd_animation_import,       kd_hierarchy_import,   kd_deform_import,
        kd_shadow_import,   kd_voxel_objects_import,   kd_voxel_cache_import, kd_voxel_pages_import,
        kd_svo_import,      kd_voxel_transform_import, kd_lighting_import,    kd_bounce_import,
        kd_deferred_import, kd_cone_trace_import,      kd_debug_view_import,  kd_resolve_import,
    };
    return import_all(s, imports, sizeof imports / sizeof *imports);
}

/* None of these keeps state of its own for a GPU system, which would not be freed. */
kd_status app_import_state_systems(kd_schedule *s)
{
    static import *const imports[] = {kd_scene_import, kd_animation_import, kd_hierarchy_import,
                                      kd_deform_import};
    kd_schedule_leave_out_gpu(s);
    return import_all(s, imports, sizeof imports / sizeof *imports);
}
