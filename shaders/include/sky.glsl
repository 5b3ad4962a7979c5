#ifndef KD_INCLUDE_SKY_GLSL
#define KD_INCLUDE_SKY_GLSL

/* What surrounds the scene. Resource "sky", bound by kd_sky_bind. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/sky.h"

layout(std140, binding = KD_BIND_SKY) uniform kd_sky_block { kd_sky_params kd_sky; };
layout(binding = KD_UNIT_SKY_MAP) uniform sampler2D sky_map;
layout(binding = KD_UNIT_SKY_CONES) uniform sampler3D sky_cones;

vec3 sky_to_map(vec3 d) { return vec3(dot(kd_sky.to_map[0].xyz, d), dot(kd_sky.to_map[1].xyz, d), dot(kd_sky.to_map[2].xyz, d)); }

/* Radiance along a unit direction. */
vec3 sky_radiance(vec3 direction)
{
    vec3 d = sky_to_map(direction);
    vec2 place = vec2(0.5 + atan(d.x, -d.z) * (0.5 / 3.14159265), acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);
    return kd_sky.ambient.rgb + kd_sky.to_map[0].w * textureLod(sky_map, place, 0.0).rgb;
}

/* Mean radiance over a cone, given the tangent of its half angle. */
vec3 sky_cone(vec3 direction, float tan_half)
{
    vec3 d = sky_to_map(direction);
    vec2 p = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    if (d.z < 0.0)
        p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    float layer = clamp(log2(tan_half / KD_SKY_TANGENT), 0.0, float(KD_SKY_LAYERS - 1));
    vec2 uv = (0.5 + (0.5 * p + 0.5) * float(KD_SKY_EDGE - 1)) / float(KD_SKY_EDGE);
    return kd_sky.ambient.rgb + kd_sky.to_map[0].w * textureLod(sky_cones, vec3(uv, (layer + 0.5) / float(KD_SKY_LAYERS)), 0.0).rgb;
}

#endif
