// Build `levels`, second half of a level: what was marked takes a number from the level's counter. One invocation a dense cell,
// or a child of a node of the level above.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/svo/taken.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level; that of the leaves: cells, y: room for cells

uint take(uint code)
{
    uint number = taken_number(pass.x);
    if (number != KD_EMPTY)
        taken_open(pass.x, number, code);
    return number;
}

void main()
{
    uint n = linear_index(), level = pass.x;
    if (level == 0u) {
        uint cell = n & ((1u << (3 * KD_DENSE_LOG2)) - 1u), c = n >> (3 * KD_DENSE_LOG2);
        if (c >= places.size.w || index[n] != KD_MARKED)
            return;
        uvec3 at = (uvec3(cell) >> uvec3(0, KD_DENSE_LOG2, 2 * KD_DENSE_LOG2)) & (uint(KD_DENSE) - 1u);
        index[n] = take(c << (3 * KD_DENSE_LOG2) | morton_encode(at));
        return;
    }
    uint parent = n >> 3;
    if (parent >= min(counters[KD_COUNT_NEED + level - 1u], places.room[level - 1u]))
        return;
    if (level == places.size.y) {
        uint place = taken_leaf_place(parent, n);
        if (leaf_words[place] == KD_MARKED)
            leaf_words[place] = taken_cell(pass.y);
    } else {
        uint place = child_place(level, parent, n);
        if (nodes[place] == KD_MARKED)
            nodes[place] = take(book[places.codes[level - 1u] + parent] * 8u + (n & 7u));
    }
}
