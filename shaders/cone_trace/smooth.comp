// Smooths every traced pixel.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/cone_trace/smooth.glsl"

void main()
{
    smooth_pixel(ivec2(gl_GlobalInvocationID.xy));
}
