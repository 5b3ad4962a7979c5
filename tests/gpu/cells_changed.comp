// Asks for every cell of cascade 0 whether something changed around it.
layout(local_size_x = 64) in;

#define KD_CHANGES_BINDING 1
#include "shaders/include/linear.glsl"
#include "shaders/include/changes.glsl"

layout(std430, binding = 0) writeonly buffer out_block { uint answers[]; };

void main()
{
    uint n = linear_index(), edge = tree.info.y;
    if (n < edge * edge * edge)
        answers[n] = uint(cells_changed_around(0u, ivec3(uvec3(n, n / edge, n / edge / edge) % edge)));
}
