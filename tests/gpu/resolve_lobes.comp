/* The layered BRDF, evaluated for one case an invocation. */

#define LAYERED
#include "shaders/include/brdf.glsl"

layout(local_size_x = 64) in;

struct lobe_case {
    vec4 albedo;  /* a: metallic */
    vec4 f0;      /* a: f90 */
    vec4 layers;  /* roughness, coat, its roughness, transmission */
    vec4 view;    /* xyz: to the eye */
    vec4 light;   /* xyz: to the light */
    vec4 reflected, tint; /* results */
};
layout(std430, binding = 0) buffer case_block { lobe_case cases[]; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(cases.length()))
        return;
    lobe_case c = cases[i];
    surface s;
    s.normal_ws = vec3(0.0, 0.0, 1.0);
    s.albedo = c.albedo.rgb;
    s.metallic = c.albedo.a;
    s.f0 = c.f0.rgb;
    s.f90 = c.f0.a;
    s.roughness = c.layers.x;
    s.coat = c.layers.y;
    s.coat_roughness = c.layers.z;
    s.transmission = c.layers.w;
    cases[i].reflected = vec4(brdf_direct(s, c.view.xyz, c.light.xyz), 0.0);
    cases[i].tint = vec4(brdf_tint(s, c.view.z), 0.0);
}
