/* Six diffuse cones of 60 degrees and one along the mirror direction, from the point itself.
 * Source  Crassin 2011 */

#include "shaders/shared/blend.h"
#include "shaders/include/emitters.glsl"

layout(std140, binding = KD_BIND_PASS) uniform blend_block { kd_blend_params blend; };

cone_settings blend_settings() { return cone_settings(blend.cone.y, blend.cone.z, blend.light.y, 1.0, blend.light.w, CONE_CLOSED, 1.0); }

float blend_span(surface s) { return tree_finest_edge(min(tree_cascade_at(s.position_ws, 0.5), tree_cascades() - 1)); }

/* What lies beyond the outermost cascade is lit as its border is. */
vec3 blend_origin(surface s)
{
    float reach = tree.cascade[tree_cascades() - 1].w * float(tree_resolution()) * (0.5 - 2.0 / float(KD_DENSE));
    vec3 origin = s.position_ws + s.face_normal_ws * (blend.cone.w * blend_span(s));
    return clamp(origin, tree.centre.xyz - reach, tree.centre.xyz + reach);
}

vec3 blend_trace(vec3 origin, vec3 direction, float tan_half, float start, out float occlusion)
{
    cone_result r = cone_trace(origin, direction, direction, tan_half, start, blend_settings());
    occlusion = r.occlusion;
    return (r.radiance * tree.light.z + r.transmittance * sky_cone(direction, tan_half)) * blend.light.x;
}

vec4 gathered_diffuse(surface s)
{
    vec3 n = s.normal_ws, up = abs(n.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 x = normalize(cross(up, n)), y = cross(n, x), origin = blend_origin(s);
    float span = blend_span(s), visible = 0.0;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 6; i++) {
        float angle = 1.2566371 * float(i), weight = i == 5 ? 0.25 : 0.15; /* five round one, by their cosines */
        vec3 direction = i == 5 ? n : 0.5 * n + 0.8660254 * (cos(angle) * x + sin(angle) * y);
        float occlusion;
        sum += weight * blend_trace(origin, direction, blend.cone.x, 0.25 * span, occlusion);
        visible += weight * (1.0 - occlusion);
    }
    sum += emitters_light(sum, s.position_ws, origin, n, 0.25 * span, 0.05, 2u, 0u, emitter_settings(blend_settings())) * blend.light.x;
    return vec4(sum, clamp(1.0 - blend.light.z * (1.0 - visible), 0.0, 1.0));
}

vec3 gathered_specular(surface s)
{
    vec3 direction = reflect(view_direction(s.position_ws), s.normal_ws);
    float below = dot(direction, s.face_normal_ws);
    if (below < 0.05)
        direction = normalize(direction + (0.05 - below) * s.face_normal_ws);
    float occlusion, tan_half = clamp(s.roughness * s.roughness, 0.03, 1.0), span = blend_span(s);
    vec3 origin = blend_origin(s), light = blend_trace(origin, direction, tan_half, span, occlusion);
    return light + emitters_reflected(s.position_ws, origin, direction, tan_half, span, emitter_settings(blend_settings())) * blend.light.x;
}
