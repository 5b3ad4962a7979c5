// What leads to the leaves of a parent: to eight of its own where something moves, else to its static cells. All that is made of
// them is to be filtered, since leaves may have changed places.

#include "shaders/include/svo_find.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/svo/moved.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: parents with room for dynamic cells, z: words of the parents' mask, w: words of `moved_cells`
layout(std430, binding = 2) readonly buffer parents_block { uint parents[]; }; // in which something moves: mask, then ranks

uint seen_block(uint number, uint code)
{
    uint word = pass.y != 0u ? parents[code >> 5] : 0u;
    if ((word >> (code & 31u) & 1u) != 0u) {
        uint rank = rank_below(parents[pass.z + (code >> 5)], word, code);
        if (rank < pass.y)
            return 255u << KD_BLOCK_BITS | (places.blocks.w + 8u * rank);
    }
    return book[places.blocks.x + number];
}

// above: number of the node above it
void show(uint number, uint code, uint above)
{
    nodes[block_place(above, code)] = seen_block(number, code);
    if (pass.x == 0u)
        book_change_dense(code);
    else
        book_change_node(pass.x, number);
}
