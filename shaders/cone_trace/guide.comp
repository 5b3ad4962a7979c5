// What weighing a traced pixel against others needs of it: shading normal and viewing depth, 0 where there is background.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/shared/gather.h"
#include "shaders/include/gbuffer.glsl"

layout(std140, binding = KD_BIND_PASS) uniform gather_block { kd_gather_params gather; };
layout(binding = 0, rgba32f) writeonly uniform image2D guide_out;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), pixel = at * int(gather.size.z);
    if (any(greaterThanEqual(pixel, ivec2(gather.size.xy))))
        return;
    float depth = gbuffer_load_depth(pixel);
    vec3 normal = octahedral_decode(texelFetch(gbuffer_normal, pixel, 0).xy);
    imageStore(guide_out, at, depth < 1.0 ? vec4(normal, view_depth(depth)) : vec4(0.0));
}
