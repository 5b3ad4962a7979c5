// After nodes of a level went or came: how many numbers are free. The list of words is done.
layout(local_size_x = 1) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level, y: 1 when nodes came
layout(std430, binding = 0) buffer counters_block { uint counters[]; };

void main()
{
    uint free = counters[KD_COUNT_FREE + pass.x], moved = counters[KD_COUNT_DIFF];
    counters[KD_COUNT_PARTS] = 0u;
    counters[KD_COUNT_FREE + pass.x] = pass.y == 0u ? free + moved : free - min(free, moved);
}
