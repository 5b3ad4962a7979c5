// Traces the pixels that refine.comp has listed.
layout(local_size_x = 64) in;

#include "shaders/cone_trace/trace.glsl"
#include "shaders/cone_trace/list.glsl"

void main()
{
    if (gl_GlobalInvocationID.x < refine_count)
        trace_pixel(refine_item(gl_GlobalInvocationID.x), int(gather.size.z));
}
