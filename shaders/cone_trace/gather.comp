// Traces every n-th pixel of both axes: one invocation each.
#define KD_GLOSSY
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/cone_trace/trace.glsl"

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int n = int(gather.size.z);
    if (all(lessThan(at * n, ivec2(gather.size.xy))))
        trace_pixel(at, n);
}
