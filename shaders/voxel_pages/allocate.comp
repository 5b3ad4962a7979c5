// Segments in: every new segment pops a free slot, from the first page that has one (Yalciner 2016, section 4.3). The CPU
// has made pages enough for all; which slot a segment gets does not matter, since all sums over voxels are order-free.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segments, y: pages
struct request {
    kd_voxel_segment segment;
    uint id, spare0, spare1, spare2;
};
layout(std430, binding = 0) readonly buffer requests_block { request requests[]; };
layout(std430, binding = 1) buffer slots_block { uint slots[]; };
layout(std430, binding = 2) writeonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 3) buffer stacks_block { uint stacks[]; };

void main()
{
    if (gl_GlobalInvocationID.x >= pass.x)
        return;
    request r = requests[gl_GlobalInvocationID.x];
    slots[r.id] = KD_EMPTY;
    for (uint page = 0u; page < pass.y; page++) {
        uint base = page * (KD_PAGE_SEGMENTS + 1u);
        uint top = stacks[base];
        while (top > 0u) {
            uint seen = atomicCompSwap(stacks[base], top, top - 1u);
            if (seen == top) {
                uint slot = page * KD_PAGE_SEGMENTS + stacks[base + top];
                slots[r.id] = slot;
                segments[slot] = r.segment;
                return;
            }
            top = seen;
        }
    }
}
