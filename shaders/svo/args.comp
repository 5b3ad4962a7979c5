// Indirect arguments: groups of 64 over so many times what a counter holds.
layout(local_size_x = 1) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: counter, y: most, z: factor, w: arguments
layout(std430, binding = 0) buffer counters_block { uint counters[]; };

void main()
{
    counters[pass.w] = (min(counters[pass.x], pass.y) * pass.z + 63u) / 64u;
    counters[pass.w + 1u] = 1u;
    counters[pass.w + 2u] = 1u;
}
