/* Light that comes to each pixel's surface straight from the lights. DIRECTIONAL, LOCAL: kinds of light there are; what
 * is not there is not compiled, since software drivers run a loop's body once even when it has nothing to do. */

#include "shaders/include/gbuffer.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/brdf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) uniform writeonly image2D direct_image;

vec3 shade(surface s, vec3 v)
{
    vec3 to_light, sum = vec3(0.0);
#ifdef DIRECTIONAL
    for (uint i = 0u; i < light_directional_count(); i++) {
        vec3 irradiance = light_sample(i, s.position_ws, to_light);
        sum += irradiance * brdf_direct(s, v, to_light) * light_shadow_directional(i, s.position_ws, s.face_normal_ws);
    }
#endif
#ifdef LOCAL
    for (uint i = light_directional_count(); i < light_count(); i++) {
        vec3 irradiance = light_sample(i, s.position_ws, to_light);
        sum += irradiance * brdf_direct(s, v, to_light) * light_shadow_local(i, s.position_ws, s.face_normal_ws);
    }
#endif
    return sum;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(kd_view.size.xy))))
        return;
    surface s = gbuffer_load(pixel);
    vec3 radiance = vec3(0.0);
    if (s.hit && !s.unlit)
        radiance = shade(s, -view_direction(s.position_ws));
    imageStore(direct_image, pixel, vec4(min(radiance, vec3(65504.0)), 0.0));
}
