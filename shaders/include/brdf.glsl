#ifndef KD_INCLUDE_BRDF_GLSL
#define KD_INCLUDE_BRDF_GLSL

/* The metallic-roughness material. Source  glTF 2.0 specification, appendix B.
 *
 * With LAYERED, known when compiling, dielectrics have a reflection of their own and a coat of varnish may lie over
 * all. Source  KHR_materials_specular, KHR_materials_clearcoat, KHR_materials_transmission */

#include "shaders/shared/brdf.h"
#include "shaders/include/surface.glsl"

const float BRDF_PI = 3.14159265358979;
const float BRDF_DIELECTRIC_F0 = KD_BRDF_DIELECTRIC_F0;
const float BRDF_MIN_ROUGHNESS = KD_BRDF_MIN_ROUGHNESS;

#ifdef LAYERED
vec3 brdf_f0(surface s) { return mix(s.f0, s.albedo, s.metallic); }
float brdf_f90(surface s) { return mix(s.f90, 1.0, s.metallic); }
vec3 brdf_diffuse_albedo(surface s) { return s.albedo * ((1.0 - s.metallic) * (1.0 - s.transmission)); }
#else
vec3 brdf_f0(surface s) { return mix(vec3(BRDF_DIELECTRIC_F0), s.albedo, s.metallic); }
float brdf_f90(surface s) { return 1.0; }
vec3 brdf_diffuse_albedo(surface s) { return s.albedo * (1.0 - s.metallic); }
#endif

/* GGX normal distribution. */
float brdf_distribution(float n_dot_h, float alpha)
{
    float a2 = alpha * alpha;
    float d = (n_dot_h * a2 - n_dot_h) * n_dot_h + 1.0;
    return a2 / (BRDF_PI * d * d);
}

/* Height-correlated Smith shadowing and masking over 4 (n.l)(n.v).
 * Source  Heitz 2014, Understanding the Masking-Shadowing Function, equation 99 */
float brdf_visibility(float n_dot_l, float n_dot_v, float alpha)
{
    float a2 = alpha * alpha;
    float v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    float l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    return 0.5 / max(v + l, 1e-7);
}

vec3 brdf_fresnel(vec3 f0, float f90, float v_dot_h)
{
    float x = clamp(1.0 - v_dot_h, 0.0, 1.0);
    float x2 = x * x;
    return f0 + (f90 - f0) * (x2 * x2 * x);
}

#ifdef LAYERED
/* Share of light that the coat keeps from what lies below: what it reflects itself. */
float brdf_coat(surface s, float n_dot_v)
{
    return s.coat * brdf_fresnel(vec3(BRDF_DIELECTRIC_F0), 1.0, n_dot_v).r;
}

/* What passes through to the other side, of light along the view. */
vec3 brdf_tint(surface s, float n_dot_v)
{
    vec3 below = 1.0 - brdf_fresnel(brdf_f0(s), brdf_f90(s), n_dot_v);
    return below * (s.transmission * (1.0 - s.metallic) * (1.0 - brdf_coat(s, n_dot_v))) * s.albedo;
}
#endif

/* BRDF times n.l: what a light's irradiance becomes in radiance towards the eye. v, l: unit, away from the
 * surface. */
vec3 brdf_direct(surface s, vec3 v, vec3 l)
{
    float n_dot_l = dot(s.normal_ws, l);
    if (n_dot_l <= 0.0)
        return vec3(0.0);
    float n_dot_v = max(dot(s.normal_ws, v), 1e-4);
    vec3 h = normalize(v + l);
    float alpha = max(s.roughness, BRDF_MIN_ROUGHNESS);
    alpha *= alpha;
    float n_dot_h = clamp(dot(s.normal_ws, h), 0.0, 1.0);
    vec3 f = brdf_fresnel(brdf_f0(s), brdf_f90(s), dot(v, h));
    float specular = brdf_distribution(n_dot_h, alpha) * brdf_visibility(n_dot_l, n_dot_v, alpha);
    vec3 reflected = ((1.0 - f) * brdf_diffuse_albedo(s) / BRDF_PI + f * specular) * n_dot_l;
#ifdef LAYERED
    float coat = brdf_coat(s, n_dot_v), coat_alpha = max(s.coat_roughness, BRDF_MIN_ROUGHNESS);
    coat_alpha *= coat_alpha;
    reflected = (1.0 - coat) * reflected +
                coat * brdf_distribution(n_dot_h, coat_alpha) * brdf_visibility(n_dot_l, n_dot_v, coat_alpha) * n_dot_l;
#endif
    return reflected;
}

/* The same of a white matte surface, whatever this one is made of. */
float brdf_white(surface s, vec3 l) { return max(dot(s.normal_ws, l), 0.0) / BRDF_PI; }

/* Share of light from all around that the specular lobe returns: f0 * x + y. A fit of our own, by least
 * squares over the integral of this very lobe on a grid of roughness and n.v, grazing views weighted down:
 * `kept` is what f0 = 1 returns (1 less what single scattering loses), `y` the part that Fresnel's term
 * adds. Off by 0.02 on average, by 0.09 at most.
 * Source  the split into x and y: Karis 2013, Real Shading in Unreal Engine 4, equation 8 */
vec2 brdf_env(float roughness, float n_dot_v)
{
    float r = roughness, q = 1.0 - n_dot_v;
    float lost = (0.3300 - 0.2205 * r) + n_dot_v * ((2.0329 * r - 0.7633) + n_dot_v * (0.1172 - 0.7865 * r));
    float kept = clamp(1.0 - r * lost, 0.0, 1.0);
    float y3 = 0.0643 + r * (0.6969 - 0.8376 * r), y5 = 1.0273 + r * (2.2688 * r - 3.1527);
    float y = q * q * q * (y3 + q * q * y5);
    y = clamp(y, 0.0, kept);
    return vec2(kept - y, y);
}

/* The same as a factor on the radiance that the glossy cone returns. */
vec3 brdf_env_specular(surface s, vec3 v)
{
    vec2 e = brdf_env(s.roughness, clamp(dot(s.normal_ws, v), 0.0, 1.0));
    return brdf_f0(s) * e.x + brdf_f90(s) * e.y;
}

#ifdef LAYERED
/* The same of the coat. */
float brdf_env_coat(surface s, vec3 v)
{
    float n_dot_v = clamp(dot(s.normal_ws, v), 0.0, 1.0);
    vec2 e = brdf_env(s.coat_roughness, n_dot_v);
    return brdf_coat(s, n_dot_v) * (e.x + e.y);
}
#endif

#endif
