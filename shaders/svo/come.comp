// Nodes of a level that come take free numbers, in the order of their codes. Levels are done from above. Where there are no
// numbers left the last ones, which are those of the outermost cascade, stay away.
layout(local_size_x = 64) in;

#include "shaders/include/svo_find.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: room on the list, y: level, z: first word of its mask
layout(std430, binding = 1) readonly buffer before_block { uint before[]; };
layout(std430, binding = 2) readonly buffer work_block { uvec2 work[]; }; // words; ranks inside blocks of 32 of them
layout(std430, binding = 6) readonly buffer sums_block { uint sums[]; };   // before the blocks
layout(std430, binding = 5) buffer masks_block { uint masks[]; };

void come(uint level, uint code, uint number)
{
    uint parent = level == 0u ? KD_EMPTY : find_node(level - 1u, code >> 3);
    if (level == 0u)
        index[dense_place(code)] = number;
    else
        nodes[child_place(level, parent, code)] = number;
    book[places.codes[level] + number] = code;
    if (level + 1u < places.size.y) {
        for (uint k = 0u; k < 8u; k++)
            nodes[child_place(level + 1u, number, k)] = KD_EMPTY;
    } else {
        book[places.blocks.x + number] = 0u;
        nodes[block_place(parent, code)] = 0u;
        if (counters[KD_COUNT_HIGH] <= number)
            atomicMax(counters[KD_COUNT_HIGH], number + 1u);
    }
    if (level + 2u == places.size.y)
        for (uint k = 0u; k < 8u; k++)
            nodes[block_place(number, k)] = 0u;
    change_above(level, code, parent);
    if (level > 0u)
        book_change_node(level, number);
}

void main()
{
    uint n = linear_index(), level = pass.y;
    if (n >= min(counters[KD_COUNT_PARTS], pass.x))
        return;
    uint word = work[n].x;
    uint bits = masks[pass.z + word] & ~before[pass.z + word], rank = sums[word >> 5] + work[n].y, free = counters[KD_COUNT_FREE + level], come_count = 0u;
    for (; bits != 0u && rank < free; bits &= bits - 1u, come_count++, rank++)
        come(level, word * 32u + uint(findLSB(bits)), book[places.free[level] + free - 1u - rank]);
    if (bits != 0u) {
        masks[pass.z + word] &= ~bits;
        counters[KD_COUNT_AWAY] = 1u;
    }
    if (come_count != 0u)
        atomicAdd(counters[KD_COUNT_NODES + 4u * level + (word * 32u >> (3u * (KD_DENSE_LOG2 + level)))], come_count);
}
