// Place of a set bit in an array that holds one entry a set bit: how many bits are set before it. `ranks` holds that for the
// first bit of every word (runtime/gpu/rank.h).
uint rank_below(uint rank_of_word, uint word, uint bit)
{
    return rank_of_word + uint(bitCount(word & ((1u << (bit & 31u)) - 1u)));
}
