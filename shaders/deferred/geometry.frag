/* Writes the surface under a pixel into the G-buffer. MASKED: alpha test. LAYERED: more than metallic-roughness. */

#include "shaders/deferred/fragment.glsl"

layout(location = 0) out vec4 out_albedo;
layout(location = 1) out uvec4 out_normal;
layout(location = 2) out vec4 out_material;
layout(location = 3) out vec4 out_emissive;
#ifdef LAYERED
layout(location = 4) out uvec4 out_layers;
#endif

void main()
{
    vec4 base = material_base_color(uv, color);
    packed_surface o = surface_pack(fragment_surface(base)); /* before a discard: derivatives need all pixels */
#ifdef MASKED
    if (base.a < kd_material.emissive.a)
        discard;
#endif
    out_albedo = o.albedo;
    out_normal = o.normal;
    out_material = o.material;
    out_emissive = o.emissive;
#ifdef LAYERED
    out_layers = o.layers;
#endif
}
