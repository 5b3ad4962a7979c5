// How many nodes a mask of leaf parents asks for, in each cascade: leaf parents themselves, and levels above them. One
// invocation 16 words, which are one node three levels above.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words, y: first word, z: words of a cascade, w: first counter
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer masks_block { uint masks[]; };

uint bytes_in(uint bits)
{
    bits |= bits >> 4;
    bits |= bits >> 2;
    return uint(bitCount((bits | bits >> 1) & 0x01010101u));
}

void main()
{
    uint first = linear_index() * 16u;
    if (first >= pass.x)
        return;
    uvec4 nodes = uvec4(0u);
    for (uint i = 0u; i < 16u; i += 2u) {
        uint a = masks[pass.y + first + i], b = masks[pass.y + first + i + 1u];
        nodes += uvec4(bitCount(a) + bitCount(b), bytes_in(a) + bytes_in(b), uint((a | b) != 0u), 0u);
    }
    if (nodes.x == 0u)
        return;
    nodes.w = 1u;
    for (uint k = 0u; k < 4u; k++)
        atomicAdd(counters[pass.w + 4u * k + first / pass.z], nodes[k]);
}
