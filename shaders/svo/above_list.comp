// Lists the cells of the first level above the outermost cascade that hold something, or did. One invocation a cell.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/linear.glsl"

void main()
{
    uint code = linear_index(), outer = places.size.w - 1u;
    if (counters[KD_COUNT_UP + places.size.w] == 0u || code >= KD_UP_CELLS)
        return;
    ivec3 low = ivec3(morton_decode(code)) * 2;
    uint filled = 0u;
    for (uint k = 0u; k < 8u; k++) {
        uint at = outer << (3 * KD_DENSE_LOG2) | morton_encode(dense_wrap(outer, low + (ivec3(k, k >> 1, k >> 2) & 1)));
        filled |= book[places.others.x + (at >> 5)] >> (at & 31u) & 1u;
    }
    uint word = places.above.x + (code >> 5), bit = 1u << (code & 31u);
    bool was = (book[word] & bit) != 0u;
    if (filled != 0u && !was)
        atomicOr(book[word], bit);
    if (filled == 0u && was)
        atomicAnd(book[word], ~bit);
    if (filled != 0u || was)
        book[places.above.y + atomicAdd(counters[KD_COUNT_ABOVE], 1u)] = code;
}
