// Lists the pixels of a grid that are traced in this frame; to the others goes what the frame before found there, or nothing.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/cone_trace/traced.glsl"
#include "shaders/cone_trace/reuse.glsl"
#include "shaders/include/work_list_fill.glsl"
#include "shaders/cone_trace/listed_pixel.glsl"

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), pixel = at * int(gather.size.z);
    if (any(greaterThanEqual(pixel, ivec2(gather.size.xy))))
        return;
    float depth = gbuffer_load_depth(pixel);
    reused_light light = reused_light(true, vec4(0.0, 0.0, 0.0, 1.0), vec4(0.0));
    if (depth < 1.0) {
        vec3 normal = texelFetch(guide_in, at * int(gather.flags.y), 0).xyz;
        light = reuse_find(at, int(gather.size.z), int(gather.flags.y), gbuffer_position(pixel, depth), normal);
    }
    if (!light.found) {
        work_add(pixel_item(at));
        return;
    }
    imageStore(diffuse_out, at, light.diffuse);
    imageStore(specular_out, at, light.specular);
}
