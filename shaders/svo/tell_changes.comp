// With one layer: dense cells whose sums are not those of the frame before. One invocation 32 of them.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std430, binding = 6) buffer told_block { uint told[]; }; // now, which is left empty, then before

void main()
{
    uint word = linear_index(), cells = places.size.w * KD_DENSE_WORDS * 32u, bits = 0u;
    if (word * 32u >= cells)
        return;
    for (uint i = 0u; i < 32u; i++) {
        uint now = told[word * 32u + i], before = told[cells + word * 32u + i];
        bits |= uint(now != before) << i;
        told[word * 32u + i] = 0u;
        told[cells + word * 32u + i] = now;
    }
    book[places.news.x + word] = bits;
}
