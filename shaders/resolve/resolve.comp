/* Puts the parts of the light together: the radiance of the chosen view, row 0 on top. */

#include "shaders/shared/resolve.h"
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/brdf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform resolve_pass { kd_resolve_params params; };
layout(binding = KD_UNIT_GI_DIFFUSE) uniform sampler2D gi_diffuse;
layout(binding = KD_UNIT_GI_SPECULAR) uniform sampler2D gi_specular;
layout(binding = KD_UNIT_DIRECT) uniform sampler2D direct;
layout(binding = 0, rgba16f) uniform writeonly image2D hdr_image;

/* A target that is not there is one black texel. */
vec4 load_gi(sampler2D target, ivec2 pixel) { return texelFetch(target, min(pixel, textureSize(target, 0) - 1), 0); }

vec3 background()
{
    bool sky = params.mode.x == KD_SHOW_FINAL || params.mode.x == KD_SHOW_DIRECT;
    return sky ? kd_lights.ambient.rgb : vec3(0.0);
}

/* Without GI the sky shines everywhere, unoccluded; with it the cones have added the sky already. */
vec3 foreground(surface s, ivec2 pixel)
{
    bool gi = params.mode.z != 0u;
    vec4 diffuse_in = gi ? load_gi(gi_diffuse, pixel) : vec4(kd_lights.ambient.rgb, 1.0);
    vec3 specular_in = gi ? load_gi(gi_specular, pixel).rgb : kd_lights.ambient.rgb;
    float lit = s.unlit ? 0.0 : 1.0;
    vec3 diffuse = brdf_diffuse_albedo(s) * diffuse_in.rgb * (s.occlusion * lit);
    vec3 specular = brdf_env_specular(s, -view_direction(s.position_ws)) * specular_in * lit;
    vec3 straight = texelFetch(direct, pixel, 0).rgb + s.emissive;
    switch (params.mode.x) {
    case KD_SHOW_DIRECT: return straight;
    case KD_SHOW_INDIRECT: return diffuse + specular;
    case KD_SHOW_AO: return vec3(diffuse_in.a);
    case KD_SHOW_SPECULAR: return specular;
    case KD_SHOW_ALBEDO: return s.unlit ? s.emissive : s.albedo;
    case KD_SHOW_NORMAL: return s.normal_ws * 0.5 + 0.5;
    case KD_SHOW_DEPTH: return vec3(view_depth(s.depth));
    }
    return straight + diffuse + specular;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(kd_view.size.xy))))
        return;
    surface s = gbuffer_load(pixel);
    vec3 c = s.hit ? foreground(s, pixel) : background();
    ivec2 top_down = ivec2(pixel.x, int(kd_view.size.y) - 1 - pixel.y);
    imageStore(hdr_image, top_down, vec4(min(c, vec3(65504.0)), s.hit ? 1.0 : 0.0));
}
