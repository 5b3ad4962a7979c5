// Parents in which something moves, or did: which cells they had.

// Does a word lead to leaves of a parent in which something moves?
bool leads_to_moving(uint block)
{
    uint first = block & KD_BLOCK_FIRST;
    return block != 0u && first >= places.blocks.w && first != KD_BLOCK_WAITS;
}

#ifdef KD_MOVED_BINDING
layout(std430, binding = KD_MOVED_BINDING) readonly buffer moved_cells_block { uint moved_cells[]; }; // which cells there were, by last frame's ranks

// Cells that a parent had, from the word that led to its leaves. still: static ones, words: of moved_cells
uint cells_before(uint block, uint still, uint words)
{
    uint rank = ((block & KD_BLOCK_FIRST) - places.blocks.w) >> 3;
    return !leads_to_moving(block) ? block >> KD_BLOCK_BITS : rank < words ? still | moved_cells[rank] : KD_EMPTY;
}
#endif
