// Attributes of static cells that were built anew, to where they stay: beside their leaf. One invocation a leaf of a touched
// parent.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/cell_pack.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: capacity of the sums, y: words of the mask, z: level of the leaf parents
layout(std430, binding = 2) readonly buffer fresh_block { uint fresh[]; }; // mask, then ranks
layout(std430, binding = 3) writeonly buffer surface_block { uvec2 surface[]; };   // albedo, normal
layout(std430, binding = 4) writeonly buffer emission_block { uvec2 emission[]; }; // emission, weight

void main()
{
    uint entry = gl_GlobalInvocationID.x >> 3, k = gl_GlobalInvocationID.x & 7u;
    if (entry >= min(counters[KD_COUNT_TOUCHED], places.size.x))
        return;
    uint number = book[places.others.w + entry];
    if (number == KD_EMPTY)
        return;
    uint bit = book[places.codes[pass.z] + number] * 8u + k, word = fresh[bit >> 5];
    uint rank = rank_below(fresh[pass.y + (bit >> 5)], word, bit);
    if ((word >> (bit & 31u) & 1u) == 0u)
        return;
    uvec4 cell = rank < pass.x ? cell_attributes_of(rank) : uvec4(0u);
    surface[number * 8u + k] = cell.xy;
    emission[number * 8u + k] = cell.zw;
}
