// Nodes of a level that go give their numbers back, in the order of their codes. Levels are done from below.
layout(local_size_x = 64) in;

#include "shaders/include/svo_find.glsl"
#include "shaders/include/svo_blocks.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: room on the list, y: level, z: first word of its mask
layout(std430, binding = 1) readonly buffer before_block { uint before[]; };
layout(std430, binding = 2) readonly buffer work_block { uvec2 work[]; }; // words; ranks inside blocks of 32 of them
layout(std430, binding = 5) readonly buffer masks_block { uint masks[]; };
layout(std430, binding = 6) readonly buffer sums_block { uint sums[]; };   // before the blocks

void vanish(uint level, uint code, uint rank)
{
    uint place, parent = KD_EMPTY, number;
    if (level == 0u) {
        place = dense_place(code);
        number = index[place];
        index[place] = KD_EMPTY;
    } else {
        parent = find_node(level - 1u, code >> 3);
        place = child_place(level, parent, code);
        number = nodes[place];
        nodes[place] = KD_EMPTY;
    }
    if (level + 1u == places.size.y) {
        block_give_back(book[places.blocks.x + number]);
        block_count_cells(code, 0u, block_count(book[places.blocks.x + number]));
        nodes[block_place(parent, code)] = 0u;
        book_tell_change(code >> (3u * level));
    }
    book[places.codes[level] + number] = KD_EMPTY;
    book[places.free[level] + counters[KD_COUNT_FREE + level] + rank] = number;
    change_above(level, code, parent);
}

void main()
{
    uint n = linear_index(), level = pass.y;
    if (n >= min(counters[KD_COUNT_PARTS], pass.x))
        return;
    uint word = work[n].x;
    uint bits = before[pass.z + word] & ~masks[pass.z + word], rank = sums[word >> 5] + work[n].y;
    if (bits != 0u)
        atomicAdd(counters[KD_COUNT_NODES + 4u * level + (word * 32u >> (3u * (KD_DENSE_LOG2 + level)))], 0u - uint(bitCount(bits)));
    for (; bits != 0u; bits &= bits - 1u)
        vanish(level, word * 32u + uint(findLSB(bits)), rank++);
}
