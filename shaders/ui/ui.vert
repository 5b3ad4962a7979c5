/* Takes the panels' triangles to the window. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/ui.h"

layout(location = 0) in vec2 in_position;
layout(location = 1) in vec2 in_uv;
layout(location = 2) in vec4 in_color;

layout(std140, binding = KD_BIND_PASS) uniform Params { kd_ui_params params; };

out vec2 uv;
out vec4 color;

void main()
{
    gl_Position = vec4(in_position * params.to_ndc.xy + vec2(-1.0, 1.0), 0.0, 1.0);
    uv = in_uv;
    color = in_color;
}
