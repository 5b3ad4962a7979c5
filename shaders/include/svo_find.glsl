// From a node's code to its number, down from the dense cell.

#include "shaders/include/svo_book.glsl"
#include "shaders/include/morton.glsl"

// What other threads of the same pass write is seen when this says coherent volatile.
#ifndef KD_FIND_ACCESS
#define KD_FIND_ACCESS
#endif

layout(std430, binding = 3) KD_FIND_ACCESS buffer index_block { uint index[]; };
layout(std430, binding = 4) KD_FIND_ACCESS buffer nodes_block { uint nodes[]; };

uint dense_place(uint code)
{
    uvec3 cell = morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u));
    return (((code >> (3 * KD_DENSE_LOG2)) * KD_DENSE + cell.z) * KD_DENSE + cell.y) * KD_DENSE + cell.x;
}

uint child_place(uint level, uint parent, uint code)
{
    return places.child[level - 1u] + parent * 8u + (code & 7u);
}

// Number of a node of `level`, KD_EMPTY when there is none.
uint find_node(uint level, uint code)
{
    uint number = index[dense_place(code >> (3u * level))];
    for (uint l = 1u; l <= level && number != KD_EMPTY; l++)
        number = nodes[child_place(l, number, code >> (3u * (level - l)))];
    return number;
}

// Place of the word that leads to the leaves of a leaf parent, beside that which leads to the parent itself.
uint block_place(uint above, uint code)
{
    uint last = places.size.y - 1u;
    return places.child[last] + (last == 0u ? dense_place(code) : above * 8u + (code & 7u));
}

// The same, found from above. level: of the leaf parents, which must be there
uint find_block_place(uint level, uint code)
{
    return block_place(level == 0u ? 0u : find_node(level - 1u, code >> 3), code);
}

// What a node's parent, or the dense cell that it is, shows has changed. `parent` is a number, for level 2 and below.
void change_above(uint level, uint code, uint parent)
{
    if (level <= 1u)
        book_change_dense(code >> (3u * level));
    else
        book_change_node(level - 1u, parent);
}
