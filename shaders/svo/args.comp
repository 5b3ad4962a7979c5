// Indirect arguments: groups of 64 over so many times what a counter holds, in rows as a dispatch takes them; the shader takes
// linear_index().
layout(local_size_x = 1) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: counter, y: most, z: factor, w: arguments
layout(std430, binding = 0) buffer counters_block { uint counters[]; };

void main()
{
    uint groups = (min(counters[pass.x], pass.y) * pass.z + 63u) / 64u, rows = max((groups + 32767u) / 32768u, 1u);
    counters[pass.w] = (groups + rows - 1u) / rows;
    counters[pass.w + 1u] = rows;
    counters[pass.w + 2u] = 1u;
}
