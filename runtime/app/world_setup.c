#include "runtime/app/world_setup.h"

#include "components/animation.h"
#include "components/camera.h"
#include "components/deform.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/sky.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "systems/animation/animation.h"
#include "systems/bounce/bounce.h"
#include "systems/cone_trace/cone_trace.h"
#include "systems/debug_view/debug_view.h"
#include "systems/deferred/deferred.h"
#include "systems/deform/deform.h"
#include "systems/film/film.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/lighting/lighting.h"
#include "systems/resolve/resolve.h"
#include "systems/scene/scene.h"
#include "systems/shadow/shadow.h"
#include "systems/sky/sky.h"
#include "systems/svo/svo.h"
#include "systems/voxel_cache/voxel_cache.h"
#include "systems/voxel_pages/voxel_pages.h"
#include "systems/voxel_transform/voxel_transform.h"

void app_register_components(kd_world *w, const kd_extension *extension)
{
    (void)KD_ID(w, kd_transform);
    (void)KD_ID(w, kd_local_matrix);
    (void)KD_ID(w, kd_world_transform);
    (void)KD_ID(w, kd_mesh_instance);
    (void)KD_ID(w, kd_skin_instance);
    (void)KD_ID(w, kd_morph_weights);
    (void)KD_ID(w, kd_animation);
    (void)KD_ID(w, kd_animation_layers);
    (void)KD_ID(w, kd_light);
    (void)KD_ID(w, kd_camera);
    (void)KD_ID(w, kd_sky);
    if (extension && extension->register_components)
        extension->register_components(w);
}

typedef kd_status import(kd_schedule *s);

static kd_status import_all(kd_schedule *s, import *const *imports, size_t count)
{
    kd_status status = KD_OK;
    for (size_t i = 0; i < count && status == KD_OK; i++)
        status = imports[i](s);
    return status;
}

static kd_status import_extension(kd_schedule *s, const kd_extension *extension)
{
    if (!extension || !extension->import_systems)
        return KD_OK;
    kd_status status = extension->import_systems(s);
    if (status != KD_OK && extension->name)
        kd_log(KD_LOG_ERROR, "%s: its systems were not added", extension->name);
    return status;
}

kd_status app_import_systems(kd_schedule *s, const kd_extension *extension)
{
    static import *const imports[] = {
        kd_scene_import,       kd_animation_import, kd_hierarchy_import,       kd_deform_import,
        kd_shadow_import,      kd_sky_import,       kd_voxel_objects_import,   kd_voxel_cache_import,
        kd_voxel_pages_import, kd_svo_import,       kd_voxel_transform_import, kd_lighting_import,
        kd_bounce_import,      kd_motion_import,    kd_deferred_import,  kd_cone_trace_import,      kd_blend_import,
        kd_debug_view_import,  kd_film_import,      kd_resolve_import,
    };
    kd_status status = import_all(s, imports, sizeof imports / sizeof *imports);
    return status == KD_OK ? import_extension(s, extension) : status;
}

/* None of ours keeps state of its own for a GPU system, which would not be freed. */
kd_status app_import_state_systems(kd_schedule *s, const kd_extension *extension)
{
    static import *const imports[] = {kd_scene_import, kd_animation_import, kd_hierarchy_import,
                                      kd_deform_import};
    kd_schedule_leave_out_gpu(s);
    kd_status status = import_all(s, imports, sizeof imports / sizeof *imports);
    return status == KD_OK ? import_extension(s, extension) : status;
}

const kd_embedded_shader *app_shaders(const kd_extension *extension)
{
    return extension ? extension->shaders : NULL;
}
