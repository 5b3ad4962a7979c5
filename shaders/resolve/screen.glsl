#ifndef KD_RESOLVE_SCREEN_GLSL
#define KD_RESOLVE_SCREEN_GLSL

/* From radiance to what is saved and shown. */

#include "shaders/shared/resolve.h"
#include "shaders/include/color.glsl"

vec3 screen_tonemap(vec3 c, uint curve)
{
    if (curve == KD_CURVE_ACES)
        return color_aces(c);
    return curve == KD_CURVE_REINHARD ? color_reinhard(c) : c;
}

/* Pictures of light. */
vec3 screen_light(vec3 c, float exposure, uint curve)
{
    return color_srgb_encode(screen_tonemap(c * exposure, curve));
}

/* Any view: what is not light skips exposure and curve. */
vec3 screen_view(vec3 c, uint show, float exposure, uint curve)
{
    if (show == KD_SHOW_AO || show == KD_SHOW_ALBEDO)
        return color_srgb_encode(c);
    if (show == KD_SHOW_NORMAL)
        return c;
    if (show == KD_SHOW_DEPTH)
        return c.r > 0.0 ? vec3(1.0 / (1.0 + c.r)) : vec3(0.0); /* near is bright */
    return screen_light(c, exposure, curve);
}

#endif
