// Cells of the dynamic layer: one invocation a leaf parent adds up the voxels on its chain (link.comp), for its eight cells at
// once, and packs them; it notes which of the eight there are. Leaves the heads of the chains empty, for the next frame.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/splat.glsl"
#include "shaders/include/cell_chain.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parents that there is room for
layout(binding = 0) uniform usamplerBuffer voxels; // rgba32ui
layout(binding = 1) uniform usamplerBuffer next;   // r32ui
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) buffer heads_block { uint heads[]; }; // first entries
layout(std430, binding = 2) writeonly buffer cells_block { uvec4 cells[]; }; // eight a parent; behind all a word for each: which there are
layout(std430, binding = 4) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 5) readonly buffer objects_block { kd_voxel_object_params objects[]; };

shared uint occupied; // cells of this group's parents

chained chain_load(uint entry)
{
    uvec4 v = texelFetch(voxels, int(entry >> 3));
    uvec3 far = uvec3(v.y, v.y >> 8, v.y >> 16) & 255u;
    bvec3 odd = equal(uvec3(v.x, v.x >> 10, v.x >> 20) & 1u, uvec3(0u)); // stored one higher
    return chained(texelFetch(next, int(entry)).r, far, odd, entry & 7u, v.z, v.w);
}

uvec3 chain_emission(uint entry, uint share)
{
    return share_emission(share, objects[segments[(entry >> 3) / KD_SEGMENT_VOXELS].object].emission.rgb);
}

// Returns how many of the eight cells are occupied.
uint make_cells(uint n)
{
    uint first = heads[n], bits = 0u;
    eight_sums sums = chain_sums(first);
#define PUT(k, surface) bits |= 1u << k; cells[n * 8u + k] = uvec4(surface, 0u, 0u);
    EIGHT_EACH(PUT, sums)
    heads[n] = KD_EMPTY;
    cells[pass.x * 8u + (n >> 2)][n & 3u] = bits;
    for (uint glow = sums.share != 0u ? bits : 0u; glow != 0u; glow &= glow - 1u) {
        uint k = uint(findLSB(glow));
        cells[n * 8u + k].zw = chain_pack_emission(first, k);
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
