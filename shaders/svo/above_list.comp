// Lists the cells of the first two levels above the outermost cascade that hold something, or did. One invocation a cell of the second.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/linear.glsl"

// Does the cell of the first level hold anything?
bool is_filled(uint code)
{
    uint outer = places.size.w - 1u, filled = 0u;
    ivec3 low = ivec3(morton_decode(code)) * 2;
    for (uint k = 0u; k < 8u; k++) {
        uint at = outer << (3 * KD_DENSE_LOG2) | morton_encode(dense_wrap(outer, low + (ivec3(k, k >> 1, k >> 2) & 1)));
        filled |= book[places.others.x + (at >> 5)] >> (at & 31u) & 1u;
    }
    return filled != 0u;
}

void main()
{
    uint n = linear_index(), word = places.above.x + (n >> 2), shift = 8u * (n & 3u);
    if (counters[KD_COUNT_UP + places.size.w] == 0u || n >= KD_UP_CELLS / 8u)
        return;
    uint now = 0u, was = book[word] >> shift & 255u;
    for (uint i = 0u; i < 8u; i++)
        now |= uint(is_filled(n * 8u + i)) << i;
    if (now != was)
        atomicXor(book[word], (now ^ was) << shift);
    for (uint work = now | was; work != 0u; work &= work - 1u)
        book[places.above.y + atomicAdd(counters[KD_COUNT_ABOVE], 1u)] = n * 8u + uint(findLSB(work));
    if ((now | was) != 0u)
        book[places.above.z + atomicAdd(counters[KD_COUNT_ABOVE_NEXT], 1u)] = n;
}
