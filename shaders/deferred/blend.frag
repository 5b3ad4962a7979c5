/* Light of a blended surface and the share of what is behind it that it hides. KD_SPARSE_LEVELS: the light that
 * arrives is gathered from the octree at the pixel itself; else the sky shines everywhere, unoccluded. What
 * shade.glsl asks for comes besides. TINTED: some surfaces of the picture hide colours unequally. */

#include "shaders/deferred/fragment.glsl"
#include "shaders/include/shade.glsl"
#include "shaders/include/sky.glsl"

layout(location = 0) out vec4 out_color;
#ifdef TINTED
layout(location = 1) out vec4 out_hidden;
#endif

#ifdef KD_SPARSE_LEVELS
#include "shaders/deferred/blend_gather.glsl"
#else
vec4 gathered_diffuse(surface s) { return vec4(sky_cone(s.normal_ws, 2.0), 1.0); }
vec3 gathered_specular(surface s)
{
    return sky_cone(reflect(view_direction(s.position_ws), s.normal_ws), s.roughness * s.roughness);
}
#endif

void main()
{
    vec4 base = material_base_color(uv, color);
    surface s = fragment_surface(base);
    s.position_ws = kd_view.position_ws.xyz + from_eye;
    s.depth = gl_FragCoord.z;
    s.albedo = clamp(s.albedo, 0.0, 1.0); /* as the G-buffer keeps them */
    s.roughness = clamp(s.roughness, 0.0, 1.0);
    s.metallic = clamp(s.metallic, 0.0, 1.0);
    float opacity = kd_material.maps.w != 0u ? 1.0 : clamp(base.a, 0.0, 1.0);
    surface traced = s;
#ifdef LAYERED
    s.coat_roughness = clamp(s.coat_roughness, 0.0, 1.0);
    s.traced_roughness = s.coat > 0.0 ? min(s.coat_roughness, s.roughness) : s.roughness;
    traced.roughness = s.traced_roughness;
#endif
    vec3 c = min(shade(s, gathered_diffuse(s), gathered_specular(traced)), vec3(65504.0));
#ifdef TINTED
    vec3 hidden = vec3(opacity);
#ifdef LAYERED
    hidden *= 1.0 - brdf_tint(s, clamp(-dot(s.normal_ws, normalize(from_eye)), 0.0, 1.0));
#endif
    out_color = vec4(c * opacity, dot(hidden, vec3(1.0 / 3.0)));
    out_hidden = vec4(hidden, 1.0);
#else
    out_color = vec4(c, opacity);
#endif
}
