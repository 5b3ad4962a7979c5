/* Integrates the BRDF over the hemisphere for each case, by the midpoint rule, one azimuth an invocation
 * (llvmpipe ends any loop after 65535 rounds). */

#include "shaders/include/brdf.glsl"

const int THETA = 768, PHI = 256;

layout(local_size_x = PHI) in;

struct brdf_case {
    vec4 material; /* albedo, metallic, roughness, n.v */
    vec4 result;   /* x: reflected share, y: what brdf_env says for the specular part */
};
layout(std430, binding = 0) buffer case_block { brdf_case cases[]; };

shared float columns[PHI];

void main()
{
    vec4 m = cases[gl_WorkGroupID.x].material;
    surface s;
    s.normal_ws = vec3(0.0, 0.0, 1.0);
    s.albedo = vec3(m.x);
    s.metallic = m.y;
    s.roughness = m.z;
    vec3 v = vec3(sqrt(1.0 - m.w * m.w), 0.0, m.w);
    float t = (float(gl_LocalInvocationIndex) + 0.5) / float(PHI);
    float phi = BRDF_PI * (1.0 - t * t); /* finer where lobes are; the other half mirrors this */
    float column = 0.0;
    for (int i = 0; i < THETA; i++) {
        float theta = (float(i) + 0.5) / float(THETA) * (0.5 * BRDF_PI);
        vec3 l = vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
        column += brdf_direct(s, v, l).r * sin(theta);
    }
    columns[gl_LocalInvocationIndex] = column * 2.0 * t; /* d phi */
    barrier();
    if (gl_LocalInvocationIndex != 0u)
        return;
    float sum = 0.0;
    for (int i = 0; i < PHI; i++)
        sum += columns[i];
    cases[gl_WorkGroupID.x].result.x = sum * (0.5 * BRDF_PI / float(THETA)) * (2.0 * BRDF_PI / float(PHI));
    cases[gl_WorkGroupID.x].result.y = brdf_env_specular(s, v).r;
}
