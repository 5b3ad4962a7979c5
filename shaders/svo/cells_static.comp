// Cells of the static layer that come anew, to where they stay: their leaf, and beside it. One invocation a touched parent adds
// up its chain (link_static.comp).
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/leaf_block.glsl"
#include "shaders/include/splat.glsl"
#include "shaders/include/cell_chain.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first patch of this round, y: patches of it, w: level of the leaf parents
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(binding = 0) uniform usamplerBuffer entries; // rgba32ui
layout(binding = 1) uniform usamplerBuffer glows;   // r32ui: objects of entries
layout(binding = 2) uniform samplerBuffer objects;  // rgba32f, eight an object
layout(std430, binding = 1) readonly buffer heads_block { uint heads[]; };
layout(std430, binding = 3) writeonly buffer albedo_block { uint albedo[]; };
layout(std430, binding = 4) writeonly buffer emission_block { uvec2 emission[]; }; // emission, area; where anything glows
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 6) writeonly buffer leaves_block { uvec2 leaves[]; };     // no light yet; normal, weight
layout(std430, binding = 2) readonly buffer touched_block { uint touched[]; }; // numbers

#include "shaders/include/stale.glsl"

chained chain_load(uint entry)
{
    uvec4 v = texelFetch(entries, int(entry));
    bvec3 odd = notEqual(uvec3(v.y >> 27, v.y >> 28, v.y >> 29) & 1u, uvec3(0u));
    return chained(v.x, uvec3(v.y, v.y >> 8, v.y >> 16) & 255u, odd, v.y >> 24 & 7u, v.z, v.w);
}

uvec3 chain_emission(uint entry, uint share)
{
    return share_emission(share, texelFetch(objects, int(texelFetch(glows, int(entry)).r) * 8 + 7).rgb);
}

void put(uint block, uint k, uvec2 surface)
{
    uint slot = block_slot(block, k);
    albedo[slot] = surface.x;
    leaves[slot] = uvec2(0u, surface.y);
}

void main()
{
    uint n = linear_index();
    if (n >= min(counters[KD_COUNT_TOUCHED], places.size.x))
        return;
    uint number = touched[n];
    if (number == KD_EMPTY)
        return;
    uint code = book[places.codes[pass.w] + number];
    if (!stale_brick(code >> (3u * pass.w)))
        return;
    uint place = (stale_place(code * 8u) >> 3) - (pass.x << 5), block = book[places.blocks.x + number];
    if (place >= pass.y << 5)
        return;
    if (KD_BLOCK_WIDE && block != 0u)
        for (uint k = 0u; k < 8u; k++)
            leaves[block_slot(block, k)] = uvec2(0u);
    uint first = block != 0u ? heads[place] : KD_EMPTY;
    uint given_up = cascade_given_up(code >> (3u * (KD_DENSE_LOG2 + pass.w)));
    eight_sums sums = chain_sums(first);
    chain_join(sums, given_up);
    eight_axes axes = chain_axes(first, sums, given_up);
#define PUT(k, surface) put(block, k, surface);
    EIGHT_EACH(PUT, sums)
    for (uint glow = tree.light.x > 0.0 ? block >> KD_BLOCK_BITS : 0u; glow != 0u; glow &= glow - 1u) {
        uint k = uint(findLSB(glow));
        emission[block_slot(block, k)] = chain_pack_emission(sums.share != 0u ? first : KD_EMPTY, k, given_up);
    }
}
