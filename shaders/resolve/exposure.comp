/* Chooses the exposure that puts the picture's geometric mean luminance to mid grey.
 * Source  Reinhard et al. 2002, Photographic Tone Reproduction, equations 1 and 2 */

#include "shaders/shared/bindings.h"
#include "shaders/shared/resolve.h"
#include "shaders/include/view.glsl"

layout(local_size_x = 256) in;
layout(std140, binding = KD_BIND_PASS) uniform resolve_pass { kd_resolve_params params; };
layout(std430, binding = 0) writeonly buffer exposure_block { float exposure; };
layout(std430, binding = 1) readonly buffer partial_block { vec2 partials[]; };

shared vec2 sums[256];

const float MID_GREY = 0.18;

void main()
{
    uint i = gl_LocalInvocationIndex;
    vec2 sum = vec2(0.0);
    for (uint j = i; j < params.mode.w; j += 256u)
        sum += partials[j];
    sums[i] = sum;
    for (uint half_size = 128u; half_size > 0u; half_size >>= 1) {
        barrier();
        if (i < half_size)
            sums[i] += sums[i + half_size];
    }
    if (i == 0u)
        exposure = kd_view.lens.z * (sums[0].y > 0.0 ? MID_GREY * exp2(-sums[0].x / sums[0].y) : 1.0);
}
