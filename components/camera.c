#include "components/camera.h"

static const kd_camera camera_default = {
    .fov_y = 0.785398163f /* 45 degrees */, .y_mag = 1, .z_near = 0.05f, .z_far = 200};
KD_COMPONENT_DEFINE_DEFAULT(
    kd_camera, "camera", &camera_default,
    KD_FIELD(kd_camera, orthographic, KD_BOOL, NULL, "parallel projection of height 2 y_mag"),
    KD_FIELD(kd_camera, inactive, KD_BOOL, NULL, "never the picture's camera"),
    KD_FIELD_RANGE(kd_camera, fov_y, KD_F32, "rad", 0.001, 3.1, "full vertical opening angle"),
    KD_FIELD_RANGE(kd_camera, y_mag, KD_F32, "m", 1e-6, 1e6, "half height of an orthographic view"),
    KD_FIELD_RANGE(kd_camera, z_near, KD_F32, "m", 1e-6, 1e6, "distance of the near plane"),
    KD_FIELD_RANGE(kd_camera, z_far, KD_F32, "m", 1e-6, 1e9, "distance of the far plane"));

KD_COMPONENT_DEFINE_FLAGS(kd_free_camera, "free_camera", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_free_camera, on, KD_BOOL, NULL, "it is used"),
                          KD_FIELD(kd_free_camera, world, KD_MAT4, NULL, "camera to world, column-major"));

KD_COMPONENT_DEFINE(kd_view, "view", KD_FIELD(kd_view, view, KD_MAT4, NULL, "world to view, column-major"),
                    KD_FIELD(kd_view, projection, KD_MAT4, NULL, "view to clip space, z in -1 to 1"),
                    KD_FIELD(kd_view, view_projection, KD_MAT4, NULL, "world to clip space"),
                    KD_FIELD(kd_view, inverse_view_projection, KD_MAT4, NULL, "clip space to world"),
                    KD_FIELD(kd_view, position_ws, KD_VEC3, "m", "where the camera stands"),
                    KD_FIELD(kd_view, forward_ws, KD_VEC3, NULL, "unit direction it looks along"),
                    KD_FIELD(kd_view, z_near, KD_F32, "m", "distance of the near plane"),
                    KD_FIELD(kd_view, z_far, KD_F32, "m", "distance of the far plane"),
                    KD_FIELD(kd_view, tan_half_fov_y, KD_F32, NULL,
                             "tangent of half the vertical opening angle; 0: orthographic"),
                    KD_FIELD(kd_view, width, KD_U32, "pixels", "picture width"),
                    KD_FIELD(kd_view, height, KD_U32, "pixels", "picture height"));
