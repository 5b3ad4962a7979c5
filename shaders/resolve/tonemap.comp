/* From radiance to the screen. Data views (occlusion, albedo, normal, depth) skip exposure and curve. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/resolve.h"
#include "shaders/include/color.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform resolve_pass { kd_resolve_params params; };
layout(std430, binding = 0) readonly buffer exposure_block { float exposure; };
layout(binding = 0) uniform sampler2D hdr;
layout(binding = 1, rgba8) uniform writeonly image2D ldr_image;

vec3 tonemap(vec3 c)
{
    if (params.mode.y == KD_CURVE_ACES)
        return color_aces(c);
    return params.mode.y == KD_CURVE_REINHARD ? color_reinhard(c) : c;
}

vec3 screen_color(vec3 c)
{
    switch (params.mode.x) {
    case KD_SHOW_ALBEDO:
    case KD_SHOW_AO: return color_srgb_encode(c);
    case KD_SHOW_NORMAL: return c;
    case KD_SHOW_DEPTH: return c.r > 0.0 ? vec3(1.0 / (1.0 + c.r)) : vec3(0.0); /* near is bright */
    }
    return color_srgb_encode(tonemap(c * exposure));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(hdr, 0))))
        return;
    imageStore(ldr_image, pixel, vec4(screen_color(texelFetch(hdr, pixel, 0).rgb), 1.0));
}
