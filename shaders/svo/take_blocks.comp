// Blocks for the static cells that come anew. One invocation a touched parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_blocks.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 2) readonly buffer touched_block { uint touched[]; }; // numbers

#include "shaders/include/stale.glsl"

void main()
{
    uint entry = linear_index();
    if (entry >= min(counters[KD_COUNT_TOUCHED], places.size.x))
        return;
    uint number = touched[entry];
    if (number == KD_EMPTY || !stale_brick(book[places.codes[pass.x] + number] >> (3u * pass.x)))
        return;
    uint cells = book[places.blocks.x + number] >> KD_BLOCK_BITS;
    if (cells == 0u)
        return;
    uint block = block_take(cells);
    if (block == 0u) // there is no room: they are not there
        block_count_cells(book[places.codes[pass.x] + number], 0u, uint(bitCount(cells)));
    book[places.blocks.x + number] = block;
}
