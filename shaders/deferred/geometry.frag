/* Writes the surface under a pixel into the G-buffer. MASKED: alpha test. LAYERED: more than metallic-roughness.
 * MOTION: and how far away in the picture it was a frame ago. */

#include "shaders/deferred/fragment.glsl"

layout(location = 0) out vec4 out_albedo;
layout(location = 1) out uvec4 out_normal;
layout(location = 2) out vec4 out_material;
layout(location = 3) out vec4 out_emissive;
#ifdef LAYERED
layout(location = 4) out uvec4 out_layers;
#endif
#ifdef MOTION
#include "shaders/shared/film.h"
#ifdef LAYERED
layout(location = 5) out vec2 out_motion;
#else
layout(location = 4) out vec2 out_motion;
#endif
layout(std140, binding = KD_BIND_PASS) uniform motion_pass { kd_motion_params motion; };
in vec4 previous_clip;

/* What was behind the camera has no place in the picture. */
vec2 motion_to_before()
{
    if (previous_clip.w <= 0.0)
        return vec2(0.0);
    return (previous_clip.xy / previous_clip.w * 0.5 + 0.5) * motion.size.xy - gl_FragCoord.xy;
}
#endif

void main()
{
    vec4 base = material_base_color(uv, color);
    packed_surface o = surface_pack(fragment_surface(base)); /* before a discard: derivatives need all pixels */
#ifdef MASKED
    if (base.a < kd_material.emissive.a)
        discard;
#endif
    out_albedo = o.albedo;
    out_normal = o.normal;
    out_material = vec4(o.material.rgb, float((object_flags & KD_OBJECT_MOVES) != 0u));
    out_emissive = o.emissive;
#ifdef LAYERED
    out_layers = o.layers;
#endif
#ifdef MOTION
    out_motion = motion_to_before();
#endif
}
