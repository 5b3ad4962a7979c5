#ifndef KANDIL_H
#define KANDIL_H

/* The library's public interface, for C11 and, with its macros in another dress, for C++17. Everything
 * declared here is exported; what a header does not say is not promised.
 *
 *     cc $(pkg-config --cflags kandil) mine.c $(pkg-config --libs kandil)
 */

#ifdef __cplusplus
/* System headers first: their templates must not stand inside extern "C". */
#include <cmath>
#include <cstdbool>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

#include <cglm/cglm.h>
extern "C" {
#endif

#include "components/animation.h"
#include "components/bounce.h"
#include "components/camera.h"
#include "components/deform.h"
#include "components/frame.h"
#include "components/light.h"
#include "components/material.h"
#include "components/mesh_instance.h"
#include "components/render_targets.h"
#include "components/scene_store.h"
#include "components/svo.h"
#include "components/transform.h"
#include "components/tree_access.h"
#include "components/voxel_scene.h"
#include "runtime/app/extension.h"
#include "runtime/asset/model.h"
#include "runtime/core/arena.h"
#include "runtime/core/clock.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"
#include "runtime/core/math.h"
#include "runtime/core/settings.h"
#include "runtime/core/status.h"
#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/path.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/reflect.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/statistics.h"
#include "runtime/ecs/system.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/embedded.h"
#include "runtime/gpu/gpu.h"
#include "runtime/gpu/rank.h"
#include "runtime/gpu/work_list.h"
#include "runtime/jobs/graph.h"
#include "runtime/jobs/jobs.h"
#include "shaders/shared/bindings.h"
#include "systems/scene/scene.h"

#ifdef __cplusplus
} /* extern "C" */

/* C takes the address of a value that is written in place; C++ gets it through a reference. Both live to the
 * end of the full expression. */
template <class type> inline const type *kd_in_place(const type &value)
{
    return &value;
}
inline kd_entity kd_spawn_list(kd_world *w, std::initializer_list<kd_value> values)
{
    return kd_spawn_values(w, values.begin(), static_cast<uint32_t>(values.size()));
}
inline kd_entity kd_spawn_child_list(kd_world *w, kd_entity parent, std::initializer_list<kd_value> values)
{
    return kd_spawn_child_values(w, parent, values.begin(), static_cast<uint32_t>(values.size()));
}
#undef KD_VAL
#undef KD_VAL_AT
#undef KD_TAG
#undef kd_spawn
#undef kd_spawn_child
#define KD_VAL(type, ...)              (kd_value{&type##_desc, kd_in_place<type>(type __VA_ARGS__)})
#define KD_VAL_AT(type, pointer)       (kd_value{&type##_desc, static_cast<const type *>(pointer)})
#define KD_TAG(type)                   (kd_value{&type##_desc, nullptr})
#define kd_spawn(w, ...)               kd_spawn_list((w), {__VA_ARGS__})
#define kd_spawn_child(w, parent, ...) kd_spawn_child_list((w), (parent), {__VA_ARGS__})
#endif

#endif
