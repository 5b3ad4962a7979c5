// Bits of the nodes of a level, from their codes: its mask, or that of leaf parents with static cells. One invocation a number.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level, y: first word, z: 1 for those with static cells alone
layout(std430, binding = 1) buffer masks_block { uint masks[]; };

void main()
{
    uint number = linear_index(), level = pass.x;
    if (number >= places.room[level])
        return;
    uint code = book[places.codes[level] + number];
    if (code != KD_EMPTY && (pass.z == 0u || book[places.blocks.x + number] != 0u))
        atomicOr(masks[pass.y + (code >> 5)], 1u << (code & 31u));
}
