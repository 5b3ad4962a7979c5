// Static cells of touched parents in stale bricks come anew: their blocks are given back, and which cells there are now stands in
// their words until blocks are taken. One invocation a touched parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_blocks.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: first patch marked, z: patches marked
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 1) readonly buffer fresh_block { uint fresh[]; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 2) readonly buffer touched_block { uint touched[]; }; // numbers

#include "shaders/include/stale.glsl"

void main()
{
    uint entry = linear_index();
    if (entry >= min(counters[KD_COUNT_TOUCHED], places.size.x))
        return;
    uint number = touched[entry];
    if (number == KD_EMPTY)
        return;
    uint code = book[places.codes[pass.x] + number];
    if (!stale_brick(code >> (3u * pass.x)))
        return;
    uint at = stale_place(code * 8u) - (pass.y << 8);
    if (at >> 8 >= pass.z)
        return;
    uint cells = fresh[at >> 5] >> (at & 31u) & 255u, block = book[places.blocks.x + number];
    if (cells != block >> KD_BLOCK_BITS)
        book_tell_change(code >> (3u * pass.x));
    block_give_back(block);
    block_count_cells(code, uint(bitCount(cells)), block_count(block));
    book[places.blocks.x + number] = cells == 0u ? 0u : cells << KD_BLOCK_BITS | KD_BLOCK_WAITS;
    if (cells != 0u)
        atomicAdd(counters[KD_COUNT_WANTED + block_slots(cells << KD_BLOCK_BITS)], 1u);
}
