// After blocks were taken: how many of each size are still on the lists.
layout(local_size_x = 8) in;

#include "shaders/include/svo_book.glsl"

void main()
{
    uint n = gl_LocalInvocationIndex + 1u, listed = min(counters[KD_COUNT_BLOCKS + n], places.blocks.z);
    counters[KD_COUNT_BLOCKS + n] = listed - min(listed, counters[KD_COUNT_GOT + n]);
}
