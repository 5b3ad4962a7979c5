// Traces the pixels that refine.comp has listed, those whose reflections are the diffuse light.
layout(local_size_x = 64) in;

#include "shaders/cone_trace/trace.glsl"
#include "shaders/include/work_list.glsl"
#include "shaders/cone_trace/listed_pixel.glsl"

void main()
{
    if (gl_GlobalInvocationID.x < work_count)
        trace_pixel(listed_pixel(gl_GlobalInvocationID.x), int(gather.size.z));
}
