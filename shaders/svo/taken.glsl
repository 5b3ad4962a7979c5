// Tables of a tree whose nodes take their numbers while voxels come (builds `atomic` and `levels`). Number n of a level is the
// n-th that was asked for; where there are none left the nodes stay away. While the build runs a table of eight words a leaf parent
// holds the numbers of the cells in the sums.

#include "shaders/include/svo_find.glsl"

layout(std430, binding = 5) KD_FIND_ACCESS buffer slots_block { uint leaf_words[]; };

uint taken_leaf_place(uint number, uint code)
{
    return number * 8u + (code & 7u);
}

uint taken_number(uint level)
{
    uint number = atomicAdd(counters[KD_COUNT_NEED + level], 1u);
    return number < places.room[level] ? number : KD_EMPTY;
}

// Number of a cell in the sums, of which there are `room`.
uint taken_cell(uint room)
{
    uint cell = atomicAdd(counters[KD_COUNT_DYNAMIC], 1u);
    return cell < room ? cell : KD_EMPTY;
}

// A node that has got its number has no children yet.
void taken_open(uint level, uint number, uint code)
{
    book[places.codes[level] + number] = code;
    for (uint k = 0u; k < 8u; k++)
        if (level + 1u < places.size.y)
            nodes[child_place(level + 1u, number, k)] = KD_EMPTY;
        else
            leaf_words[taken_leaf_place(number, k)] = KD_EMPTY;
}
