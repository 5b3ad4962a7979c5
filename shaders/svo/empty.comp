// The tree without nodes: all numbers are free, the lowest on top.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/linear.glsl"

void main()
{
    uint n = linear_index();
    for (uint level = 0u; level < places.size.y; level++) {
        if (n >= places.room[level])
            continue;
        book[places.codes[level] + n] = KD_EMPTY;
        book[places.free[level] + n] = places.room[level] - 1u - n;
        if (n == 0u)
            counters[KD_COUNT_FREE + level] = places.room[level];
    }
}
