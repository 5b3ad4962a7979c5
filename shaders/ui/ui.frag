/* Colour of a panel's pixel: the vertex's, with the opacity of the letter. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/ui.h"

layout(std140, binding = KD_BIND_PASS) uniform Params { kd_ui_params params; };
layout(binding = KD_UNIT_UI_FONT) uniform sampler2D font;

in vec2 uv;
in vec4 color;

layout(location = 0) out vec4 out_color;

void main()
{
    vec2 pixel = vec2(gl_FragCoord.x, params.to_ndc.z - gl_FragCoord.y);
    if (any(lessThan(pixel, params.clip.xy)) || any(greaterThanEqual(pixel, params.clip.zw)))
        discard;
    out_color = vec4(color.rgb, color.a * texture(font, uv).r);
}
