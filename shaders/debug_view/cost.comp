// View "cost": how many samples of the tree the cones of a pixel took; nothing where its light was interpolated. One traced
// pixel stands for the block of pixels that its light goes to.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/shared/bindings.h"
#include "shaders/shared/gather.h"
#include "shaders/shared/debug_view.h"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_debug_view_params params; }; // view.z: spacing of traced pixels
layout(std430, binding = 1) readonly buffer samples_block { uint counts[KD_CONE_COUNTERS]; uint pixel_samples[]; };
layout(binding = KD_UNIT_GBUFFER_DEPTH) uniform sampler2D gbuffer_depth;
layout(binding = 0, rgba16f) writeonly uniform image2D hdr_image;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(params.view.xy);
    if (any(greaterThanEqual(pixel, size)))
        return;
    ivec2 traced = pixel - pixel % int(params.view.z);
    float samples = float(pixel_samples[traced.y * size.x + traced.x]);
    float hit = float(texelFetch(gbuffer_depth, pixel, 0).r < 1.0);
    imageStore(hdr_image, ivec2(pixel.x, size.y - 1 - pixel.y), vec4(vec3(samples), hit));
}
