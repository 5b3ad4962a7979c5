// Copies 16 bytes an invocation: what memory gives at best to a pass that reads and writes.
layout(local_size_x = 128) in;

#include "shaders/include/linear.glsl"

layout(std430, binding = 0) readonly buffer from_block { uvec4 from[]; };
layout(std430, binding = 1) writeonly buffer to_block { uvec4 to[]; };

void main()
{
    uint n = linear_index();
    if (n < uint(from.length()))
        to[n] = from[n];
}
