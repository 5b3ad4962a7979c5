#ifndef KD_COMPONENTS_TRANSFORM_H
#define KD_COMPONENTS_TRANSFORM_H

#include "runtime/core/math.h"
#include "runtime/ecs/component.h"

/* Pose relative to the parent entity; scale before rotation before translation. */
typedef struct kd_transform {
    kd_vec3 position; /* m */
    kd_quat rotation;
    kd_vec3 scale;
} kd_transform;
KD_COMPONENT_DECLARE(kd_transform); /* default: no translation, no rotation, scale 1 */
#define KD_TRANSFORM_IDENTITY                                                                                \
    {                                                                                                        \
        .rotation = {0, 0, 0, 1}, .scale = { 1, 1, 1 }                                                       \
    }

/* Replaces kd_transform where a node's matrix has shear and cannot be written as one. */
typedef struct kd_local_matrix {
    kd_mat4 matrix;
} kd_local_matrix;
KD_COMPONENT_DECLARE(kd_local_matrix);

/* Written by the hierarchy system alone. */
typedef struct kd_world_transform {
    kd_mat4 matrix; /* model to world */
} kd_world_transform;
KD_COMPONENT_DECLARE(kd_world_transform); /* default: identity */

#endif
