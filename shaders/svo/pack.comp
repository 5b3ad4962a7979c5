// Attributes of the dynamic layer's cells from their sums, one invocation a cell of the round.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/shared/voxel.h"
#include "shaders/include/cell_pack.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first cell of this round, y: cells of it
layout(std430, binding = 0) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 2) writeonly buffer attributes_block { uvec4 attributes[]; };

void main()
{
    uint cell = linear_index();
    if (cell < pass.y && pass.x + cell < counters[KD_COUNT_DYNAMIC])
        attributes[pass.x + cell] = cell_attributes_of(cell);
}
