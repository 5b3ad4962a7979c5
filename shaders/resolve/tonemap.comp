/* From what was drawn to the picture, with a measured exposure. DEEP: in 16 bits too. */

#include "shaders/shared/bindings.h"
#include "shaders/resolve/screen.glsl"
#include "shaders/resolve/legend.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform resolve_pass { kd_resolve_params params; };
layout(std430, binding = 0) readonly buffer exposure_block { float exposure; };
layout(binding = 0) uniform sampler2D hdr;
layout(binding = 1, rgba8) uniform writeonly image2D ldr_image;
#ifdef DEEP
layout(binding = 2, rgba16ui) uniform writeonly uimage2D deep_image;
#endif

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(hdr, 0))))
        return;
    vec4 c = texelFetch(hdr, pixel, 0);
    vec3 shown;
    if (params.mode.x == KD_SHOW_COST)
        shown = legend_over(heat_color(c, params.mode.z), pixel, textureSize(hdr, 0), params.mode.z);
    else
        shown = screen_view(c.rgb, params.mode.x, exposure, params.mode.y);
    imageStore(ldr_image, pixel, vec4(shown, 1.0));
#ifdef DEEP
    imageStore(deep_image, pixel, uvec4(clamp(shown, 0.0, 1.0) * 65535.0 + 0.5, 65535u));
#endif
}
