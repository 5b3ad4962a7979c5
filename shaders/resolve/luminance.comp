/* Sums log2 of the luminance over 16x16 pixels, black ones left out. Halving sums in a fixed order, so that
 * every run gives the same bits. */

#include "shaders/include/color.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 0) uniform sampler2D hdr;
layout(std430, binding = 1) writeonly buffer partial_block { vec2 partials[]; }; /* x: sum, y: pixels */

shared vec2 sums[256];

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool inside = all(lessThan(pixel, textureSize(hdr, 0)));
    float y = inside ? color_luminance(texelFetch(hdr, pixel, 0).rgb) : 0.0;
    uint i = gl_LocalInvocationIndex;
    sums[i] = y > 1e-6 ? vec2(log2(y), 1.0) : vec2(0.0);
    for (uint half_size = 128u; half_size > 0u; half_size >>= 1) {
        barrier();
        if (i < half_size)
            sums[i] += sums[i + half_size];
    }
    if (i == 0u)
        partials[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = sums[0];
}
