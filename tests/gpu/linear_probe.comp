// Counts how often each index of a linear dispatch comes, and how many come beyond the count.
layout(local_size_x = 4) in;

#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: indices
layout(std430, binding = 2) buffer seen_block { uint seen[]; }; // one more word than indices

void main()
{
    atomicAdd(seen[min(linear_index(), pass.x)], 1u);
}
