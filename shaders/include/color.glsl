#ifndef KD_INCLUDE_COLOR_GLSL
#define KD_INCLUDE_COLOR_GLSL

/* From linear light to the screen. Primaries are those of sRGB throughout. */

float color_luminance(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); } /* Rec. 709 */

/* Source  IEC 61966-2-1 */
vec3 color_srgb_encode(vec3 c)
{
    c = clamp(c, 0.0, 1.0);
    return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

vec3 color_srgb_decode(vec3 c)
{
    return mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, lessThanEqual(c, vec3(0.04045)));
}

/* Source  Narkowicz 2015, ACES Filmic Tone Mapping Curve: a fit of the ACES reference and sRGB output
 * transforms. 0.6 puts mid grey where the transforms have it. */
vec3 color_aces(vec3 c)
{
    c *= 0.6;
    return clamp(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14), 0.0, 1.0);
}

/* On luminance, so that hue stays. Source  Reinhard et al. 2002, equation 3 */
vec3 color_reinhard(vec3 c) { return c / (1.0 + color_luminance(c)); }

#endif
