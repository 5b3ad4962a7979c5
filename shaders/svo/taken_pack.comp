// Attributes of cells from their sums, to beside their leaves, and the bits of the leaf mask. One invocation a leaf.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/cell_sums_pack.glsl"
#include "shaders/include/tree_params.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: cells that there is room for, y: level of the leaf parents
layout(std430, binding = 2) readonly buffer leaves_block { uvec2 leaves[]; };
layout(std430, binding = 3) writeonly buffer surface_block { uvec2 surface[]; };   // albedo, normal, weight
layout(std430, binding = 4) writeonly buffer emission_block { uvec2 emission[]; }; // emission, area; where anything glows
layout(std430, binding = 5) buffer mask_block { uint mask[]; };

void main()
{
    uint slot = linear_index(), number = slot >> 3;
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint cell = leaves[slot].x;
    if (cell >= pass.x)
        return;
    uint code = book[places.codes[pass.y] + number] * 8u + (slot & 7u);
    uvec4 words = cell_attributes_of(cell);
    surface[slot] = words.xy;
    if (tree.light.x > 0.0)
        emission[slot] = words.zw;
    atomicOr(mask[code >> 5], 1u << (code & 31u));
}
