// Room for the blocks of static cells (leaf_block.glsl). What is given back waits on a list of its size; what finds no room on
// the list is lost until all blocks are moved together (svo/gather_blocks.comp). Where a block lies cannot be seen.

#include "shaders/include/svo_book.glsl"
#include "shaders/include/leaf_block.glsl"

void block_give_back(uint block)
{
    uint n = block_slots(block);
    if (n == 0u)
        return;
    uint i = atomicAdd(counters[KD_COUNT_BLOCKS + n], 1u);
    if (i < places.blocks.z)
        book[places.blocks.y + (n - 1u) * places.blocks.z + i] = block & KD_BLOCK_FIRST;
}

// A block for so many cells (bits), 0 when there is no room. None is given back in the same pass.
uint block_take(uint cells)
{
    uint n = block_slots(cells << KD_BLOCK_BITS), i = atomicAdd(counters[KD_COUNT_GOT + n], 1u);
    uint listed = min(counters[KD_COUNT_BLOCKS + n], places.blocks.z), first;
    if (i < listed)
        first = book[places.blocks.y + (n - 1u) * places.blocks.z + listed - 1u - i];
    else
        first = atomicAdd(counters[KD_COUNT_TOP], n);
    return first + n <= places.blocks.w ? cells << KD_BLOCK_BITS | first : 0u;
}

// Cells of a parent with this code came or went.
void block_count_cells(uint code, uint came, uint went)
{
    uint c = code >> (3u * (KD_DENSE_LOG2 + places.size.y - 1u));
    if (came == went)
        return;
    atomicAdd(counters[KD_COUNT_CELLS + c], came - went);
    atomicAdd(counters[KD_COUNT_STATIC], came - went);
}
