#ifndef KD_INCLUDE_SHADE_GLSL
#define KD_INCLUDE_SHADE_GLSL

/* What a surface sends to the eye, or the part of it that a view shows.
 *
 * SHOW (KD_SHOW_*), DIRECTIONAL and LOCAL (kinds of light there are: at least one) are known when
 * compiling: software drivers run both sides of a branch, and a loop's body once even when it has nothing to
 * do. Loops end in their condition: such drivers run a body that is left at its head once more. */

#include "shaders/shared/gather.h"
#include "shaders/shared/resolve.h"
#include "shaders/include/lights.glsl"
#include "shaders/include/tile_lights.glsl"
#include "shaders/include/brdf.glsl"

const uint show = SHOW;

/* Light arrives as at a white matte surface when light alone is shown. */
vec3 reflected(surface s, vec3 v, vec3 to_light)
{
    return show == KD_SHOW_LIGHT ? vec3(brdf_white(s, to_light)) : brdf_direct(s, v, to_light);
}

vec3 light_directional(surface s, vec3 v, uint i)
{
    vec3 to_light, irradiance = light_sample(i, s.position_ws, to_light);
    return irradiance * reflected(s, v, to_light) * light_shadow_directional(i, s.position_ws, s.face_normal_ws);
}

vec3 light_local(surface s, vec3 v, uint i)
{
    vec3 to_light, irradiance = light_sample(i, s.position_ws, to_light);
    return irradiance * reflected(s, v, to_light) * light_shadow_local(i, s.position_ws, s.face_normal_ws);
}

vec3 direct_light(surface s, vec3 v)
{
    uint i = 0u;
    vec3 sum = vec3(0.0);
#ifdef DIRECTIONAL
    do
        sum += light_directional(s, v, i++);
    while (i < light_directional_count());
#endif
#ifdef LOCAL
    light_walk walk;
    if (light_first(walk, i)) {
        do
            sum += light_local(s, v, i);
        while (light_next(walk, i));
    }
#endif
    return sum;
}

/* What the surface reflects specularly does not reach its diffuse layer. */
vec3 indirect_diffuse(surface s, vec3 v, vec3 gathered)
{
    return brdf_diffuse_albedo(s) * max(1.0 - brdf_env_specular(s, v), 0.0) * gathered * s.occlusion;
}

#ifdef LAYERED
/* One reflection is gathered, of the sharpest layer; rougher ones lie between it and light from all around. */
vec3 blurred(vec3 diffuse, vec3 specular, float traced, float roughness)
{
    float t = (roughness - traced) / max(KD_GATHER_ROUGH - traced, 1e-3);
    return mix(specular, diffuse, clamp(t, 0.0, 1.0));
}

float coat_share(surface s, vec3 v) { return brdf_coat(s, clamp(dot(s.normal_ws, v), 0.0, 1.0)); }

vec3 indirect_specular(surface s, vec3 v, vec3 diffuse, vec3 specular)
{
    vec3 base = brdf_env_specular(s, v) * blurred(diffuse, specular, s.traced_roughness, s.roughness);
    vec3 coat = brdf_env_coat(s, v) * blurred(diffuse, specular, s.traced_roughness, s.coat_roughness);
    return (1.0 - coat_share(s, v)) * base + coat;
}
#else
float coat_share(surface s, vec3 v) { return 0.0; }
vec3 indirect_specular(surface s, vec3 v, vec3 diffuse, vec3 specular) { return brdf_env_specular(s, v) * specular; }
#endif

/* The light that the view shows, of a surface that is not unlit. */
vec3 shade_light(surface s, vec3 v, vec3 diffuse, vec3 specular)
{
    if (show == KD_SHOW_DIRECT)
        return direct_light(s, v);
    if (show == KD_SHOW_LIGHT)
        return direct_light(s, v) + diffuse * s.occlusion;
    vec3 glossy = indirect_specular(s, v, diffuse, specular);
    if (show == KD_SHOW_SPECULAR)
        return glossy;
    vec3 indirect = (1.0 - coat_share(s, v)) * indirect_diffuse(s, v, diffuse) + glossy;
    return show == KD_SHOW_INDIRECT ? indirect : indirect + direct_light(s, v);
}

/* diffuse: rgb irradiance / pi that arrives, a ambient visibility; specular: radiance along the mirror
 * direction. */
vec3 shade(surface s, vec4 diffuse, vec3 specular)
{
    if (show == KD_SHOW_AO)
        return vec3(diffuse.a);
    if (show == KD_SHOW_ALBEDO)
        return s.unlit ? s.emissive : s.albedo;
    if (show == KD_SHOW_NORMAL)
        return s.normal_ws * 0.5 + 0.5;
    if (show == KD_SHOW_DEPTH)
        return vec3(view_depth(s.depth));
    vec3 emitted = show == KD_SHOW_FINAL || show == KD_SHOW_DIRECT ? s.emissive : vec3(0.0);
    vec3 light = shade_light(s, -view_direction(s.position_ws), diffuse.rgb, specular);
    return emitted + (s.unlit ? vec3(0.0) : light);
}

#endif
