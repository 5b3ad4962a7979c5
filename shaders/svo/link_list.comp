// Lists the groups of voxels that there are, so that nothing is done for empty places of segments. One invocation a segment slot.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first slot of this round, y: slots of it
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) writeonly buffer list_block { uint list[]; };

void main()
{
    uint slot = linear_index();
    if (slot >= pass.y)
        return;
    uint groups = (segments[pass.x + slot].count + KD_MOVING_GROUP - 1u) / KD_MOVING_GROUP;
    uint entry = atomicAdd(counters[KD_COUNT_PARTS], groups);
    for (uint g = 0u; g < groups; g++)
        list[entry + g] = (pass.x + slot) * KD_MOVING_GROUPS + g;
}
