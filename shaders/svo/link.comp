// Chains the dynamic layer's page voxels to the leaf parents whose cells they cover: entry 8 * voxel + corner, where the corner
// stands for a parent (splat_parents). A parent's place is the rank of its mask bit. Chains come in any order; what is made of
// them (cells.comp) does not depend on it.
layout(local_size_x = 64) in;

#include "shaders/include/splat_parents.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parents that there is room for, y: words of their mask, z: first segment of this round
layout(binding = 0) uniform usamplerBuffer voxels; // rgba32ui
layout(std430, binding = 4) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 5) readonly buffer list_block { uint list[]; };       // of groups
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer parents_block { uint parents[]; }; // mask, then ranks
layout(std430, binding = 2) buffer heads_block { uint heads[]; };              // first entry
layout(std430, binding = 3) writeonly buffer next_block { uint next[]; };           // from this round's first entry on

void link(uint entry, uint code)
{
    uint word = parents[code >> 5], rank = rank_below(parents[pass.y + (code >> 5)], word, code);
    if ((word >> (code & 31u) & 1u) == 0u || rank >= pass.x)
        return;
    next[entry - pass.z * (KD_SEGMENT_VOXELS * 8u)] = atomicExchange(heads[rank], entry);
}

void main()
{
    uint entry = linear_index() / KD_MOVING_GROUP;
    if (entry >= counters[KD_COUNT_PARTS])
        return;
    uint slot = list[entry] / KD_MOVING_GROUPS, voxel = list[entry] * KD_MOVING_GROUP + gl_LocalInvocationIndex;
    if (voxel - slot * KD_SEGMENT_VOXELS >= segments[slot].count)
        return;
    uvec2 place = texelFetch(voxels, int(voxel)).xy;
    if (place.x == KD_NO_VOXEL)
        return;
    splat s = splat_unpack(place.x, place.y);
    uint c = segments[slot].chunk_cascade >> 28;
    splat_codes codes = splat_parent_codes(s, c);
    for (uint corners = splat_parents(s, splat_corners(s, c)); corners != 0u; corners &= corners - 1u) {
        uint k = uint(findLSB(corners));
        link(voxel * 8u + k, splat_parent_code(codes, k));
    }
}
