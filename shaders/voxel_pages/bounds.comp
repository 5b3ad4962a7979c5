// Bounds of the groups of voxels in new segments, in cells of their chunk: low and high corner, 10:10:10 each.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/linear.glsl"
#include "shaders/include/voxel_pack.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segments
struct request {
    kd_voxel_segment segment;
    uint id, spare0, spare1, spare2;
};
layout(std430, binding = 0) readonly buffer requests_block { request requests[]; };
layout(std430, binding = 1) readonly buffer slots_block { uint slots[]; };
layout(binding = 0) uniform usamplerBuffer shape; // rg32ui
layout(std430, binding = 3) writeonly buffer bounds_block { uvec2 bounds[]; };

void main()
{
    uint n = linear_index(), group = n % KD_SEGMENT_GROUPS;
    if (n / KD_SEGMENT_GROUPS >= pass.x)
        return;
    request r = requests[n / KD_SEGMENT_GROUPS];
    uint slot = slots[r.id];
    uint begin = group * KD_GROUP_VOXELS, end = min(begin + KD_GROUP_VOXELS, r.segment.count);
    if (slot == KD_EMPTY)
        return;
    uvec3 low = uvec3(1023u), high = uvec3(0u);
    for (uint i = begin; i < end; i++) {
        uvec3 cell = cell_unpack(texelFetch(shape, int(r.segment.first + i)).r);
        low = min(low, cell);
        high = max(high, cell);
    }
    bounds[slot * KD_SEGMENT_GROUPS + group] = uvec2(cell_pack(low), cell_pack(high));
}
