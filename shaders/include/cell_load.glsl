// What a leaf cell of the tree holds, from the buffers of both layers.

#include "shaders/include/svo_book.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/leaf_block.glsl"
#include "shaders/include/cell_attributes.glsl"

#ifndef KD_LEAVES_ACCESS
#define KD_LEAVES_ACCESS readonly
#endif

layout(std430, binding = 1) KD_LEAVES_ACCESS buffer leaves_block { uvec2 leaves[]; };  // of static cells: normal and weight as they are
layout(std430, binding = 2) readonly buffer moving_block { uint moving[]; };             // leaf parents of the dynamic layer: mask, then ranks
layout(std430, binding = 3) readonly buffer albedo_block { uint static_albedo[]; };      // of static cells, beside their leaves
layout(std430, binding = 4) readonly buffer emission_block { uvec2 static_emission[]; }; // where anything glows
layout(std430, binding = 5) readonly buffer dynamic_block { uvec4 dynamic_cells[]; };       // eight a parent; behind all, a word for each: which there are

struct cell_parent {
    uint code;
    uint block; // of its static cells
    uint rank;  // among the parents in which something moves; KD_EMPTY: nothing does
    uint moves; // cells that do, a bit each
};

// Leaf parent `number`. dynamic_room: parents with room for dynamic cells; 0 when nothing moves.
cell_parent cell_parent_of(uint number, uint code, uint dynamic_room)
{
    cell_parent p = cell_parent(code, book[places.blocks.x + number], KD_EMPTY, 0u);
    uint at = code >> 5, bits = dynamic_room != 0u ? moving[at] : 0u;
    if ((bits >> (code & 31u) & 1u) != 0u) {
        uint rank = rank_below(moving[at + places.news.y], bits, code);
        if (rank < dynamic_room) {
            p.rank = rank;
            p.moves = dynamic_cells[dynamic_room * 8u + (rank >> 2)][rank & 3u];
        }
    }
    return p;
}

// Slot of its leaf k; KD_EMPTY: there is none.
uint cell_slot(cell_parent p, uint k)
{
    if (p.rank != KD_EMPTY)
        return places.blocks.w + p.rank * 8u + k;
    return block_has(p.block, k) ? block_slot(p.block, k) : KD_EMPTY;
}

// Attributes of its leaf k; weight 0 when it is empty.
cell_attributes cell_load(cell_parent p, uint k)
{
    cell_attributes a;
    a.albedo = a.normal = a.emission = vec3(0.0);
    a.double_sided = 0.0;
    a.thin = false;
    a.weight = 0u;
    a.area = 0.0;
    if (block_has(p.block, k)) {
        uint slot = block_slot(p.block, k);
        uvec2 glow = tree.light.x > 0.0 ? static_emission[slot] : uvec2(0u);
        a = cell_attributes_unpack(uvec4(static_albedo[slot], leaves[slot].y, glow));
    }
    if ((p.moves >> k & 1u) != 0u)
        a = cell_attributes_merge(a, cell_attributes_unpack(dynamic_cells[p.rank * 8u + k]));
    return a;
}
