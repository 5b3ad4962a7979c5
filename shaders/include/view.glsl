#ifndef KD_INCLUDE_VIEW_GLSL
#define KD_INCLUDE_VIEW_GLSL

/* The camera of this frame. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

layout(std140, binding = KD_BIND_VIEW) uniform kd_view_block { kd_view_params kd_view; };

bool view_is_orthographic() { return kd_view.projection[2][3] == 0.0; }

/* Direction from the camera's side to the point, unit length. */
vec3 view_direction(vec3 p_ws)
{
    return view_is_orthographic() ? kd_view.forward_ws.xyz : normalize(p_ws - kd_view.position_ws.xyz);
}

/* Distance along the viewing axis [m] of a depth buffer value 0 … 1: the projection's third row solved for
 * z. */
float view_depth(float depth)
{
    mat4 p = kd_view.projection;
    float z_ndc = depth * 2.0 - 1.0;
    return -(p[3][2] - z_ndc * p[3][3]) / (z_ndc * p[2][3] - p[2][2]);
}

/* World position of a depth buffer value at `uv` (0 … 1, row 0 at the bottom). The inverse matrix gives the
 * ray alone and the projection its length: a point unprojected as a whole loses centimetres a hundred metres
 * away. */
vec3 view_position(vec2 uv, float depth)
{
    vec4 far = kd_view.inverse_view_projection * vec4(uv * 2.0 - 1.0, 1.0, 1.0);
    vec3 forward = kd_view.forward_ws.xyz;
    if (view_is_orthographic()) {
        vec3 far_ws = far.xyz / far.w;
        vec3 eye = kd_view.position_ws.xyz;
        return far_ws + forward * (view_depth(depth) - dot(far_ws - eye, forward));
    }
    vec3 ray = far.xyz - kd_view.position_ws.xyz * far.w;
    return kd_view.position_ws.xyz + ray * (view_depth(depth) / dot(ray, forward));
}

#endif
