// Blocks for the cells of leaf parents that have taken their numbers. One invocation a leaf parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_blocks.glsl"
#include "shaders/svo/taken.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: cells that there is room for, y: level of the leaf parents

void main()
{
    uint number = linear_index();
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.y] + number], cells = 0u;
    for (uint k = 0u; k < 8u; k++)
        cells |= uint(leaf_words[taken_leaf_place(number, k)] < pass.x) << k;
    uint block = cells == 0u ? 0u : block_take(cells);
    book[places.blocks.x + number] = block;
    nodes[find_block_place(pass.y, code)] = block;
    if (block != 0u)
        atomicAdd(counters[KD_COUNT_CELLS + (code >> (3u * (KD_DENSE_LOG2 + pass.y)))], block_count(block));
}
