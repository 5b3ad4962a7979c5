#include "runtime/app/world_setup.h"

#include "systems/animation/animation.h"
#include "systems/deferred/deferred.h"
#include "systems/deform/deform.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/resolve/resolve.h"
#include "systems/scene/scene.h"
#include "systems/shadow/shadow.h"

kd_status app_import_systems(kd_schedule *s)
{
    static kd_status (*const imports[])(kd_schedule *) = {
        kd_scene_import,  kd_animation_import, kd_hierarchy_import, kd_deform_import,
        kd_shadow_import, kd_deferred_import,  kd_resolve_import,
    };
    kd_status status = KD_OK;
    for (size_t i = 0; i < sizeof imports / sizeof *imports && status == KD_OK; i++)
        status = imports[i](s);
    return status;
}
