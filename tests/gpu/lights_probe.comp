/* Asks the lights of a frame about points in space. */

#include "shaders/include/lights.glsl"

layout(local_size_x = 1) in;

struct probe {
    vec4 position_ws; /* w: light */
    vec4 normal_ws;   /* w: offset of the voxel [m] */
    vec4 irradiance;  /* w: light_shadow */
    vec4 to_light;    /* w: light_shadow_voxel_* */
};
layout(std430, binding = 0) buffer probe_block { probe probes[]; };

float voxel_shadow(uint light, vec3 p)
{
    return light_is_directional(light) ? light_shadow_voxel_directional(light, p) : light_shadow_voxel_local(light, p);
}

void main()
{
    uint i = gl_WorkGroupID.x, light = uint(probes[i].position_ws.w);
    vec3 p = probes[i].position_ws.xyz, n = probes[i].normal_ws.xyz, to_light;
    probes[i].irradiance.rgb = light_sample(light, p, to_light);
    probes[i].irradiance.w = light_shadow(light, p, n);
    probes[i].to_light = vec4(to_light, voxel_shadow(light, p + n * probes[i].normal_ws.w));
}
