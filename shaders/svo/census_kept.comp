// Static cells that stay: those of leaf parents outside of what is built anew. One invocation a leaf parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/leaf_block.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: 1 when some are built anew
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };

#include "shaders/include/stale.glsl"

void main()
{
    uint number = linear_index();
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.x] + number];
    if (code == KD_EMPTY || (pass.y != 0u && stale_brick(code >> (3u * pass.x))))
        return;
    uint block = book[places.blocks.x + number];
    if (block != 0u)
        atomicAdd(counters[KD_COUNT_CENSUS_CELLS + (code >> (3u * (KD_DENSE_LOG2 + pass.x)))], block_count(block));
}
