// Node table: for every occupied node of a level the words of its eight children, one word each: the child's number, or
// empty. One invocation a node.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: counter of the level, y: first child word (masks, ranks), z: capacity of children, w: first slot
layout(std140, binding = 1) uniform list_place { uvec4 place; }; // x: first entry of the level's list, y: capacity of the level
layout(std430, binding = 0) readonly buffer masks_block { uint masks[]; };
layout(std430, binding = 1) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 2) readonly buffer list_block { uint list[]; };
layout(std430, binding = 3) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 4) writeonly buffer nodes_block { uint nodes[]; };

void main()
{
    uint node = gl_GlobalInvocationID.x;
    if (node >= min(counters[pass.x], place.y))
        return;
    uint first = list[place.x + node] * 8u; // code of the first child
    uint word = masks[pass.y + (first >> 5)], shift = first & 31u;
    uint rank = ranks[pass.y + (first >> 5)] + uint(bitCount(word & ((1u << shift) - 1u)));
    for (uint i = 0u; i < 8u; i++) {
        bool there = (word >> (shift + i) & 1u) != 0u;
        nodes[pass.w + node * 8u + i] = there && rank < pass.z ? rank : KD_EMPTY;
        rank += uint(there);
    }
}
