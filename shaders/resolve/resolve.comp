/* Adds up what reaches the eye from each pixel: emission, light straight from the lights, and the gathered
 * light. Writes the radiance of the chosen view and, with LDR, its picture; row 0 on top.
 *
 * SHOW (KD_SHOW_*), DIRECTIONAL and LOCAL (kinds of light there are) are known when compiling: software
 * drivers run both sides of a branch, and a loop's body once even when it has nothing to do. */

#include "shaders/resolve/screen.glsl"
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/brdf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform resolve_pass { kd_resolve_params params; };
layout(binding = KD_UNIT_GI_DIFFUSE) uniform sampler2D gi_diffuse;
layout(binding = KD_UNIT_GI_SPECULAR) uniform sampler2D gi_specular;
layout(binding = 0, rgba16f) uniform writeonly image2D hdr_image;
layout(binding = 1, rgba8) uniform writeonly image2D ldr_image;

const uint show = SHOW;

/* Light arrives as at a white matte surface when light alone is shown. */
vec3 reflected(surface s, vec3 v, vec3 to_light)
{
    return show == KD_SHOW_LIGHT ? vec3(brdf_white(s, to_light)) : brdf_direct(s, v, to_light);
}

vec3 direct_light(surface s, vec3 v)
{
    vec3 to_light, sum = vec3(0.0);
#ifdef DIRECTIONAL
    for (uint i = 0u; i < light_directional_count(); i++) {
        vec3 irradiance = light_sample(i, s.position_ws, to_light);
        sum += irradiance * reflected(s, v, to_light) *
               light_shadow_directional(i, s.position_ws, s.face_normal_ws);
    }
#endif
#ifdef LOCAL
    for (uint i = light_directional_count(); i < light_count(); i++) {
        vec3 irradiance = light_sample(i, s.position_ws, to_light);
        sum += irradiance * reflected(s, v, to_light) *
               light_shadow_local(i, s.position_ws, s.face_normal_ws);
    }
#endif
    return sum;
}

/* Light from all around: rgb irradiance / pi, a ambient visibility. Without GI the sky shines everywhere,
 * unoccluded; with it the cones have added the sky already. */
vec4 gathered_diffuse(ivec2 pixel)
{
    return params.mode.z != 0u ? texelFetch(gi_diffuse, pixel, 0) : vec4(kd_lights.ambient.rgb, 1.0);
}
vec3 gathered_specular(ivec2 pixel)
{
    return params.mode.z != 0u ? texelFetch(gi_specular, pixel, 0).rgb : kd_lights.ambient.rgb;
}

/* What the surface reflects specularly does not reach its diffuse layer. */
vec3 indirect_diffuse(surface s, vec3 v, ivec2 pixel)
{
    vec3 passed = max(1.0 - brdf_env_specular(s, v), 0.0);
    return brdf_diffuse_albedo(s) * passed * gathered_diffuse(pixel).rgb * s.occlusion;
}
vec3 indirect_specular(surface s, vec3 v, ivec2 pixel)
{
    return brdf_env_specular(s, v) * gathered_specular(pixel);
}

/* The light that the view shows, of a surface that is not unlit. */
vec3 shaded(surface s, vec3 v, ivec2 pixel)
{
    if (show == KD_SHOW_DIRECT)
        return direct_light(s, v);
    if (show == KD_SHOW_LIGHT)
        return direct_light(s, v) + gathered_diffuse(pixel).rgb * s.occlusion;
    if (show == KD_SHOW_SPECULAR)
        return indirect_specular(s, v, pixel);
    vec3 indirect = indirect_diffuse(s, v, pixel) + indirect_specular(s, v, pixel);
    return show == KD_SHOW_INDIRECT ? indirect : indirect + direct_light(s, v);
}

vec3 foreground(surface s, ivec2 pixel)
{
    if (show == KD_SHOW_AO)
        return vec3(gathered_diffuse(pixel).a);
    if (show == KD_SHOW_ALBEDO)
        return s.unlit ? s.emissive : s.albedo;
    if (show == KD_SHOW_NORMAL)
        return s.normal_ws * 0.5 + 0.5;
    if (show == KD_SHOW_DEPTH)
        return vec3(view_depth(s.depth));
    vec3 emitted = show == KD_SHOW_FINAL || show == KD_SHOW_DIRECT ? s.emissive : vec3(0.0);
    vec3 light = shaded(s, -view_direction(s.position_ws), pixel);
    return emitted + (s.unlit ? vec3(0.0) : light);
}

vec3 background()
{
    return show == KD_SHOW_FINAL || show == KD_SHOW_DIRECT ? kd_lights.ambient.rgb : vec3(0.0);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(kd_view.size.xy))))
        return;
    surface s = gbuffer_load(pixel);
    vec3 c = min(s.hit ? foreground(s, pixel) : background(), vec3(65504.0));
    ivec2 top_down = ivec2(pixel.x, int(kd_view.size.y) - 1 - pixel.y);
    imageStore(hdr_image, top_down, vec4(c, s.hit ? 1.0 : 0.0));
#ifdef LDR
    imageStore(ldr_image, top_down, vec4(screen_view(c, show, kd_view.lens.z, params.mode.y), 1.0));
#endif
}
