// Cells of the dynamic layer: one invocation a leaf parent adds up the voxels on its chain (link.comp), for its eight cells at
// once, packs them, notes which of the eight there are, and leads the tree to them. Leaves the heads of the chains empty, for the next frame.
layout(local_size_x = 64) in;

#define KD_MOVED_BINDING 5
#include "shaders/include/linear.glsl"
#include "shaders/include/svo_find.glsl"
#include "shaders/svo/moved.glsl"
#include "shaders/include/splat_parents.glsl"
#include "shaders/include/cell_chain.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parents that there is room for, y: level of the leaf parents, z: words of `moved_cells`
layout(binding = 0) uniform usamplerBuffer voxels; // rgba32ui
layout(binding = 1) uniform usamplerBuffer next;   // r32ui
layout(binding = 2) uniform usamplerBuffer segments; // rgba32ui: object, first voxel, count, chunk and cascade
layout(binding = 3) uniform samplerBuffer objects;   // rgba32f, eight an object
layout(std430, binding = 1) buffer heads_block { uint heads[]; }; // first entries
layout(std430, binding = 2) writeonly buffer cells_block { uvec4 cells[]; }; // eight a parent; behind all a word for each: which there are

shared uint occupied; // cells of this group's parents

chained chain_load(uint entry)
{
    uvec4 v = texelFetch(voxels, int(entry >> 3));
    uvec3 far = uvec3(v.y, v.y >> 8, v.y >> 16) & 255u;
    bvec3 odd = equal(uvec3(v.x, v.x >> 10, v.x >> 20) & 1u, uvec3(0u)); // stored one higher
    return chained(texelFetch(next, int(entry)).r, far, odd, entry & 7u, v.z, v.w);
}

uvec4 segment_of(uint entry) { return texelFetch(segments, int((entry >> 3) / KD_SEGMENT_VOXELS)); }

uvec3 chain_emission(uint entry, uint share)
{
    return share_emission(share, texelFetch(objects, int(segment_of(entry).x) * 8 + 7).rgb);
}

// Code of the parent for which an entry is on a chain.
uint parent_code(uint entry)
{
    uvec2 place = texelFetch(voxels, int(entry >> 3)).xy;
    return splat_parent_code(splat_parent_codes(splat_unpack(place.x, place.y), segment_of(entry).w >> 28), entry & 7u);
}

// The word that leads to the leaves of the parent with this code leads to those of place n among what moves.
void show(uint n, uint code, uint cells_moving)
{
    uint level = pass.y, above = level == 0u ? 0u : find_node(level - 1u, code >> 3);
    uint number = level == 0u ? index[dense_place(code)] : above == KD_EMPTY ? KD_EMPTY : nodes[child_place(level, above, code)];
    if (number == KD_EMPTY) // there was no room for it
        return;
    uint place = block_place(above, code), still = book[places.blocks.x + number] >> KD_BLOCK_BITS;
    if (cells_before(nodes[place], still, pass.z) != (still | cells_moving))
        book_tell_change(code >> (3u * level));
    nodes[place] = 255u << KD_BLOCK_BITS | (places.blocks.w + 8u * n);
    if (level == 0u)
        book_change_dense(code);
    else
        book_change_node(level, number);
}

// Returns how many of the eight cells are occupied.
uint make_cells(uint n)
{
    uint first = heads[n], bits = 0u, code = first != KD_EMPTY ? parent_code(first) : 0u;
    uint given_up = cascade_given_up(code >> (3u * (KD_DENSE_LOG2 + pass.y)));
    eight_sums sums = chain_sums(first);
    chain_join(sums, given_up);
    eight_axes axes = chain_axes(first, sums, given_up);
#define PUT(k, surface) bits |= 1u << k; cells[n * 8u + k] = uvec4(surface, 0u, 0u);
    EIGHT_EACH(PUT, sums)
    heads[n] = KD_EMPTY;
    cells[pass.x * 8u + (n >> 2)][n & 3u] = bits;
    if (first != KD_EMPTY)
        show(n, code, bits);
    for (uint glow = sums.share != 0u ? bits : 0u; glow != 0u; glow &= glow - 1u) {
        uint k = uint(findLSB(glow));
        cells[n * 8u + k].zw = chain_pack_emission(first, k, given_up);
    }
    return uint(bitCount(bits));
}

void main()
{
    uint n = linear_index(), local = gl_LocalInvocationIndex;
    if (local == 0u)
        occupied = 0u;
    barrier();
    if (n < min(counters[KD_COUNT_PARENTS], pass.x))
        atomicAdd(occupied, make_cells(n));
    barrier();
    if (local == 0u)
        atomicAdd(counters[KD_COUNT_DYNAMIC], occupied);
}
