/* Six diffuse cones of 60 degrees and one along the mirror direction, from the point itself.
 * Source  Crassin 2011 */

#include "shaders/shared/blend.h"
#include "shaders/include/cone.glsl"

layout(std140, binding = KD_BIND_PASS) uniform blend_block { kd_blend_params blend; };

cone_settings blend_settings() { return cone_settings(blend.cone.y, blend.cone.z, blend.light.y); }

float blend_span(surface s) { return tree.cascade[min(tree_cascade_at(s.position_ws, 0.5), tree_cascades() - 1)].w; }

/* What lies beyond the outermost cascade is lit as its border is. */
vec3 blend_origin(surface s)
{
    float reach = tree.cascade[tree_cascades() - 1].w * float(tree_resolution()) * (0.5 - 2.0 / float(KD_DENSE));
    vec3 origin = s.position_ws + s.face_normal_ws * (blend.cone.w * blend_span(s));
    return clamp(origin, tree.centre.xyz - reach, tree.centre.xyz + reach);
}

vec3 blend_light(cone_result r) { return (r.radiance * tree.light.z + r.transmittance * blend.light.w) * blend.light.x; }

vec4 gathered_diffuse(surface s)
{
    vec3 n = s.normal_ws, up = abs(n.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 x = normalize(cross(up, n)), y = cross(n, x), origin = blend_origin(s);
    float span = blend_span(s), visible = 0.0;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 6; i++) {
        float angle = 1.2566371 * float(i), weight = i == 5 ? 0.25 : 0.15; /* five round one, by their cosines */
        vec3 direction = i == 5 ? n : 0.5 * n + 0.8660254 * (cos(angle) * x + sin(angle) * y);
        cone_result r = cone_trace(origin, direction, direction, blend.cone.x, 0.25 * span, blend_settings());
        sum += weight * blend_light(r);
        visible += weight * (1.0 - r.occlusion);
    }
    return vec4(sum, clamp(1.0 - blend.light.z * (1.0 - visible), 0.0, 1.0));
}

vec3 gathered_specular(surface s)
{
    vec3 direction = reflect(view_direction(s.position_ws), s.normal_ws);
    float below = dot(direction, s.face_normal_ws);
    if (below < 0.05)
        direction = normalize(direction + (0.05 - below) * s.face_normal_ws);
    float tan_half = clamp(s.roughness * s.roughness, 0.03, 1.0);
    return blend_light(cone_trace(blend_origin(s), direction, direction, tan_half, blend_span(s), blend_settings()));
}
