// Lists the groups of voxels of the dynamic layer by the kind of their objects, and puts together what all voxels of a segment
// share, so that each program runs its own kind alone and nothing is done for empty places. One invocation a segment slot.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 2) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(std430, binding = 3) writeonly buffer records_block { uvec4 records[]; };
layout(std430, binding = 4) buffer work_block { uint work[]; };

void main()
{
    uint slot = linear_index();
    if (slot >= pass.x || segments[slot].count == 0u)
        return;
    kd_voxel_segment segment = segments[slot];
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    uvec4 info = objects[segment.object].info;
    uint at = slot * KD_MOVING_RECORD;
    records[at] = floatBitsToUint(chunk.origin);
    bool glows = objects[segment.object].emission.rgb != vec3(0.0);
    records[at + 1u] = uvec4(segment.first, segment.count, segment.chunk_cascade >> 28 | (glows ? KD_MOVING_GLOWS : 0u), chunk.info.z + segment.first - chunk.info.x);
    records[at + 2u] = uvec4(segment.object, info.yzw);
    uint groups = (segment.count + KD_MOVING_GROUP - 1u) / KD_MOVING_GROUP;
    uint entry = atomicAdd(work[KD_MOVING_COUNT(info.x)], groups), list = KD_MOVING_LIST(info.x, pass.x);
    for (uint g = 0u; g < groups; g++)
        work[list + entry + g] = slot * KD_MOVING_GROUPS + g;
}
