// Segments out: push the slots of segments that have left back on the stack of their page.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segments
layout(std430, binding = 0) readonly buffer ids_block { uint ids[]; };
layout(std430, binding = 1) buffer slots_block { uint slots[]; };
layout(std430, binding = 2) buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 3) buffer stacks_block { uint stacks[]; }; // a page: top, then its free slots

void main()
{
    if (gl_GlobalInvocationID.x >= pass.x)
        return;
    uint id = ids[gl_GlobalInvocationID.x];
    uint slot = slots[id];
    if (slot == KD_EMPTY)
        return;
    slots[id] = KD_EMPTY;
    segments[slot].count = 0u;
    uint page = slot / KD_PAGE_SEGMENTS, base = page * (KD_PAGE_SEGMENTS + 1u);
    uint top = atomicAdd(stacks[base], 1u);
    stacks[base + 1u + top] = slot % KD_PAGE_SEGMENTS;
}
