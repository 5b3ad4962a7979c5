/* Takes the vertices of the draw list to the screen. MOTION: to where they were a frame ago, too. */

#include "shaders/include/view.glsl"
#include "shaders/include/object.glsl"

layout(location = KD_LOC_POSITION) in vec3 in_position;
layout(location = KD_LOC_NORMAL) in vec4 in_normal;
layout(location = KD_LOC_TANGENT) in vec4 in_tangent;
layout(location = KD_LOC_UV0) in vec2 in_uv0;
layout(location = KD_LOC_UV1) in vec2 in_uv1;
layout(location = KD_LOC_COLOR) in vec4 in_color;
layout(location = KD_LOC_OBJECT) in uint in_object;

#ifdef MOTION
#include "shaders/shared/film.h"
layout(location = KD_LOC_PREVIOUS) in vec3 in_previous;
layout(std140, binding = KD_BIND_PASS) uniform motion_pass { kd_motion_params motion; };
layout(std430, binding = 1) readonly buffer previous_block { mat4 previous_models[]; };
out vec4 previous_clip;
#endif

out vec3 from_eye;
out vec3 normal_ws;
out vec4 tangent_ws; /* w: side of the bitangent */
out vec4 uv;
out vec4 color;
flat out uint object_flags; /* KD_OBJECT_* */

void main()
{
    vec3 p_ws = object_position(in_object, in_position);
    gl_Position = kd_view.view_projection * vec4(p_ws, 1.0);
    from_eye = p_ws - kd_view.position_ws.xyz;
    normal_ws = normalize(object_normal(in_object, in_normal.xyz));
    object_flags = object_flags_of(in_object);
    float mirrored = (object_flags & KD_OBJECT_MIRRORED) != 0u ? 1.0 : 0.0;
    tangent_ws = vec4(object_direction(in_object, in_tangent.xyz), in_tangent.w * (1.0 - 2.0 * mirrored));
    uv = vec4(in_uv0, in_uv1);
    color = in_color;
#ifdef MOTION
    previous_clip = motion.view_projection * (previous_models[in_object] * vec4(in_previous, 1.0));
#endif
}
