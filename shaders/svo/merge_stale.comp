// First step up the tree, where the static layer is built anew. One invocation a stale patch: a word of leaf parents, which is
// eight words of cells in Morton order. Reduces eight cells that were built anew to one bit of their parent, and joins the
// dynamic layer's parents.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 layers; }; // x: patches marked, y: first word of the parents' mask, z: sparse levels, w: bits of its words; layers: x: 0 when nothing moves, y: first patch marked
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 1) buffer static_block { uint parents_static[]; }; // bits of parents
layout(std430, binding = 2) buffer diff_block { uint diff[]; };
layout(std430, binding = 3) buffer parents_block { uint parents[]; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 6) readonly buffer fresh_block { uint fresh[]; };

#include "shaders/svo/merge.glsl"
#include "shaders/svo/stale_parents.glsl"

uint parents_of(uint cells)
{
    uint four = 0u;
    for (uint k = 0u; k < 4u; k++)
        four |= uint(((cells >> (8u * k)) & 255u) != 0u) << k;
    return four;
}

void main()
{
    uint n = linear_index();
    if (n >= pass.x)
        return;
    uint word = stale[stale_at.patches + layers.y + n], touch = stale_parents(pass.z - 1u, word), still = parents_static[word] & ~touch;
    for (uint i = 0u; i < 8u; i++)
        still |= parents_of(fresh[n * 8u + i]) << (4u * i);
    parents_static[word] = still;
    put_parents(word, still | (layers.x != 0u ? parents_dynamic(word) : 0u));
}
