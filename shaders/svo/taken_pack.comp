// Attributes of cells from their sums, to their leaves and beside them. One invocation a leaf.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/leaf_block.glsl"
#include "shaders/include/cell_sums_pack.glsl"
#include "shaders/include/tree_params.glsl"

layout(std430, binding = 2) readonly buffer slots_block { uint leaf_words[]; };
layout(std430, binding = 3) writeonly buffer albedo_block { uint albedo[]; };
layout(std430, binding = 4) writeonly buffer emission_block { uvec2 emission[]; }; // emission, area; where anything glows
layout(std430, binding = 5) writeonly buffer leaves_block { uvec2 leaves[]; };     // no light yet; normal, weight

void main()
{
    uint number = linear_index() >> 3, k = linear_index() & 7u;
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint block = book[places.blocks.x + number], slot = block_slot(block, k);
    if (!block_has(block, k)) {
        if (block != 0u && KD_BLOCK_WIDE)
            leaves[slot] = uvec2(0u);
        return;
    }
    uvec4 words = cell_attributes_of(leaf_words[number * 8u + k], 0u);
    albedo[slot] = words.x;
    leaves[slot] = uvec2(0u, words.y);
    if (tree.light.x > 0.0)
        emission[slot] = words.zw;
}
