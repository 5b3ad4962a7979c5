/* Draws one layer of a shadow map. MASKED: texture coordinates go along for the alpha test. */

#include "shaders/shared/bindings.h"
#include "shaders/include/object.glsl"

layout(std140, binding = KD_BIND_PASS) uniform shadow_pass { mat4 shadow_matrix; }; /* world to [0,1]^3 */

layout(location = KD_LOC_POSITION) in vec3 in_position;
layout(location = KD_LOC_OBJECT) in uint in_object;
#ifdef MASKED
layout(location = KD_LOC_UV0) in vec2 in_uv0;
layout(location = KD_LOC_UV1) in vec2 in_uv1;
layout(location = KD_LOC_COLOR) in vec4 in_color;
out vec4 uv;
out float opacity;
#endif

void main()
{
    vec4 p = shadow_matrix * vec4(object_position(in_object, in_position), 1.0);
    gl_Position = vec4(2.0 * p.xyz - p.w, p.w);
#ifdef MASKED
    uv = vec4(in_uv0, in_uv1);
    opacity = in_color.a;
#endif
}
