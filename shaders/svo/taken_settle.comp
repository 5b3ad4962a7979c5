// The counters of a tree whose nodes have taken their numbers, as the other passes expect them. Cells lie beside their leaves as
// those of the static layer do, and count as such.
layout(local_size_x = 1) in;

#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: cells that there is room for

void main()
{
    uint levels = places.size.y;
    for (uint level = 0u; level < levels; level++) {
        uint taken = min(counters[KD_COUNT_NEED + level], places.room[level]);
        counters[KD_COUNT_FREE + level] = places.room[level] - taken;
        if (level > 0u)
            counters[KD_COUNT_CHANGED + level] = taken;
        if (level + 1u == levels)
            counters[KD_COUNT_HIGH] = taken;
    }
    counters[KD_COUNT_FRESH] = counters[KD_COUNT_DYNAMIC];
    counters[KD_COUNT_STATIC] = min(counters[KD_COUNT_DYNAMIC], pass.x);
    counters[KD_COUNT_DYNAMIC] = 0u;
}
