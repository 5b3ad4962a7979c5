#ifndef KD_COMPONENTS_CAMERA_H
#define KD_COMPONENTS_CAMERA_H

#include <stdbool.h>

#include "runtime/core/math.h"
#include "runtime/ecs/world.h"

/* A camera at the entity's world transform, looking along its -Z. The active one with the lowest entity index
 * is used. */
typedef struct kd_camera {
    bool orthographic;
    bool inactive;
    float fov_y;         /* rad */
    float y_mag;         /* m, half height, orthographic */
    float z_near, z_far; /* m */
} kd_camera;
KD_COMPONENT_DECLARE(kd_camera); /* default: perspective, 45 degrees, 0.05 … 200 m */

/* Singleton: a pose that stands in place of the active camera's, whose lens is kept: somebody looks round. */
typedef struct kd_free_camera {
    bool on;
    kd_mat4 world; /* as of a camera's entity */
} kd_free_camera;
KD_COMPONENT_DECLARE(kd_free_camera);

/* Singleton: the camera of this frame, written by the camera system. Clip space as GL: z in -1 … 1. */
typedef struct kd_view {
    kd_mat4 view, projection, view_projection, inverse_view_projection;
    kd_vec3 position_ws, forward_ws;
    float z_near, z_far, tan_half_fov_y;
    uint32_t width, height; /* pixels */
} kd_view;
KD_COMPONENT_DECLARE(kd_view);

#endif
