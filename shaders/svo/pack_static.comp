// Attributes of static cells that were built anew, to where they stay: their leaf, and beside it. One invocation a leaf of a
// touched parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/leaf_block.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/cell_sums_pack.glsl"
#include "shaders/include/tree_params.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first cell of this round, y: cells of it, z: where the ranks begin, w: level of the leaf parents
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 2) readonly buffer fresh_block { uint fresh[]; }; // mask, then ranks
layout(std430, binding = 3) writeonly buffer albedo_block { uint albedo[]; };
layout(std430, binding = 6) writeonly buffer leaves_block { uvec2 leaves[]; };     // no light yet; normal, weight
layout(std430, binding = 4) writeonly buffer emission_block { uvec2 emission[]; }; // emission, area; where anything glows

#include "shaders/include/stale.glsl"

void main()
{
    uint entry = linear_index() >> 3, k = linear_index() & 7u;
    if (entry >= min(counters[KD_COUNT_TOUCHED], places.size.x))
        return;
    uint number = book[places.others.w + entry];
    if (number == KD_EMPTY)
        return;
    uint code = book[places.codes[pass.w] + number];
    if (!stale_brick(code >> (3u * pass.w)))
        return;
    uint block = book[places.blocks.x + number], slot = block_slot(block, k);
    uint at = stale_place(code * 8u + k), word = fresh[at >> 5], rank = rank_below(fresh[pass.z + (at >> 5)], word, at);
    if (!block_has(block, k)) {
        if (block != 0u && KD_BLOCK_WIDE)
            leaves[slot] = uvec2(0u);
        return;
    }
    if (rank - pass.x >= pass.y)
        return;
    uvec4 cell = cell_attributes_of(rank - pass.x);
    albedo[slot] = cell.x;
    leaves[slot] = uvec2(0u, cell.y);
    if (tree.light.x > 0.0)
        emission[slot] = cell.zw;
}
