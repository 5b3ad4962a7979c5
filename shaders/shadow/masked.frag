/* Drops what the material's mask cuts out of a shadow. */

#include "shaders/include/material.glsl"

in vec4 uv;
in float opacity;

void main()
{
    if (material_base_color(uv, vec4(1.0, 1.0, 1.0, opacity)).a < kd_material.emissive.a)
        discard;
}
