// Leaf parents of a word of their mask that lie in stale bricks. Needs the buffer `stale` and its places `stale_at`.

// Spreads the low four bits to bytes of ones.
uint bytes_of(uint four)
{
    uint ones = (four & 1u) | (four & 2u) << 7 | (four & 4u) << 14 | (four & 8u) << 21;
    return ones * 255u;
}

// levels: from the dense cells down to theirs
uint stale_parents(uint levels, uint word)
{
    if (levels == 0u)
        return stale[stale_at.bits + word];
    if (levels == 1u)
        return bytes_of(stale[stale_at.bits + (word >> 3)] >> (4u * (word & 7u)));
    uint brick = levels == 2u ? word >> 1 : word >> 4;
    return (stale[stale_at.bits + (brick >> 5)] >> (brick & 31u) & 1u) != 0u ? KD_EMPTY : 0u;
}
