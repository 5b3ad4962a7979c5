// A block: the leaves of a parent that there are, one after the other. Its word has the first one's slot in 24 bits and above them
// a bit for each of the eight; 0: none. Trees with one sparse level, which are small, have slots for all eight: cones then need not
// count bits. So have parents in which something moves, behind the slots of what stands still.

#ifndef KD_BLOCK_WIDE
#define KD_BLOCK_WIDE (places.size.y == 1u)
#endif

bool block_has(uint block, uint k) { return (block >> (KD_BLOCK_BITS + k) & 1u) != 0u; }

uint block_slot(uint block, uint k)
{
    return (block & KD_BLOCK_FIRST) + (KD_BLOCK_WIDE ? k : uint(bitCount((block >> KD_BLOCK_BITS) & ((1u << k) - 1u))));
}

uint block_count(uint block) { return uint(bitCount(block >> KD_BLOCK_BITS)); }

// Slots of it.
uint block_slots(uint block)
{
    uint n = block_count(block);
    return n != 0u && KD_BLOCK_WIDE ? 8u : n;
}
