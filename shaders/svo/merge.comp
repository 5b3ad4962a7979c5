// First step up the tree, where something moves, or did in the frame before: joins the leaf parents of both layers. One
// invocation four words of leaf parents; most have nothing to do.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 layers; }; // x: words of parents, y: first of their mask, w: bits of its words; layers.x: 0 when nothing moves
layout(binding = 1) uniform usamplerBuffer still;  // rgba32ui: the words of the static layer's parents
layout(binding = 2) uniform usamplerBuffer before; // rgba32ui: parents that moved in the frame before
layout(std430, binding = 2) buffer diff_block { uint diff[]; };
layout(std430, binding = 3) buffer parents_block { uint parents[]; };

#include "shaders/svo/merge.glsl"

void main()
{
    uint n = linear_index();
    if (n * 4u >= pass.x)
        return;
    uvec4 moves = layers.x != 0u ? four_parents_dynamic(n) : uvec4(0u), did = texelFetch(before, int(n));
    uvec4 either = counters[KD_COUNT_AWAY] != 0u ? uvec4(1u) : moves | did; // there may be room now for nodes that stayed away
    uvec4 joined = texelFetch(still, int(n)) | moves;
    uint work = uint(either.x != 0u) | uint(either.y != 0u) << 1 | uint(either.z != 0u) << 2 | uint(either.w != 0u) << 3;
    for (; work != 0u; work &= work - 1u) {
        uint k = uint(findLSB(work));
        put_parents(n * 4u + k, joined[k]);
    }
}
