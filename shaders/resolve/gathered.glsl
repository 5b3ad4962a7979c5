#ifndef KD_RESOLVE_GATHERED_GLSL
#define KD_RESOLVE_GATHERED_GLSL

/* Light that arrives at a pixel from all around. The includer has surface.glsl's, view.glsl's and sky.glsl's, and
 * defines GATHERED_IS_THERE: whether the GI targets hold light, and GATHERED_UNIT: what it is multiplied by. */

layout(binding = KD_UNIT_GI_DIFFUSE) uniform sampler2D gi_diffuse;
layout(binding = KD_UNIT_GI_SPECULAR) uniform sampler2D gi_specular;

const float HEMISPHERE = 2.0; /* tangent of the widest cones of a sky, which stand for a hemisphere */

/* rgb irradiance / pi, a ambient visibility. Without GI the sky shines everywhere, unoccluded; with it the cones
 * have added the sky already. */
vec4 gathered_diffuse(surface s, ivec2 pixel)
{
    return GATHERED_IS_THERE ? texelFetch(gi_diffuse, pixel, 0) * vec4(vec3(GATHERED_UNIT), 1.0)
                             : vec4(sky_cone(s.normal_ws, HEMISPHERE), 1.0);
}
vec3 gathered_specular(surface s, ivec2 pixel)
{
#ifdef LAYERED
    float roughness = s.traced_roughness;
#else
    float roughness = s.roughness;
#endif
    return GATHERED_IS_THERE ? texelFetch(gi_specular, pixel, 0).rgb * GATHERED_UNIT
                             : sky_cone(reflect(view_direction(s.position_ws), s.normal_ws), roughness * roughness);
}

#endif
