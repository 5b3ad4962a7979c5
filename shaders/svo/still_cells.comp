// Occupancy of the static layer, for the change mask. One invocation a leaf parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words of a layer's mask, y: level of the leaf parents
layout(std430, binding = 2) buffer changes_block { uint changes[]; };

void main()
{
    uint number = linear_index();
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.y] + number];
    if (code != KD_EMPTY)
        atomicOr(changes[pass.x + (code >> 2)], book[places.blocks.x + number] >> KD_BLOCK_BITS << (8u * (code & 3u)));
}
