// What a leaf cell of the tree holds, from the buffers of both layers.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/cell_attributes.glsl"

layout(std430, binding = 1) readonly buffer masks_block { uint masks[]; };         // of the static layer
layout(std430, binding = 2) readonly buffer moving_block { uint moving[]; };       // of the dynamic layer; its leaf parents, mask and ranks
layout(std430, binding = 3) readonly buffer surface_block { uvec2 static_surface[]; };  // of static cells, beside their leaves
layout(std430, binding = 4) readonly buffer emission_block { uvec2 static_emission[]; }; // where anything glows
layout(std430, binding = 5) readonly buffer dynamic_block { uvec4 dynamic_cells[]; };

// The eight cells of a leaf parent: which are occupied, and where those that move lie.
struct cell_block {
    uint resting, moving; // a bit a cell
    uint first_moving;    // in dynamic_cells
};

// code: of the parent; layer_words: of a layer's mask, dynamic_room: leaf parents with room for dynamic cells; 0 when nothing
// moves.
cell_block cell_block_of(uint code, uint layer_words, uint dynamic_room)
{
    uint word = code >> 2, shift = 8u * (code & 3u);
    cell_block b = cell_block((masks[word] >> shift) & 255u, 0u, 0u);
    if (dynamic_room != 0u && ((moving[word] >> shift) & 255u) != 0u) {
        uint at = layer_words + (code >> 5), rank = rank_below(moving[at + (layer_words >> 3)], moving[at], code);
        b.moving = rank < dynamic_room ? (moving[word] >> shift) & 255u : 0u;
        b.first_moving = rank * 8u;
    }
    return b;
}

// Attributes of cell k of a block whose leaves begin at first_slot; weight 0 when it is empty.
cell_attributes cell_of_block(cell_block b, uint first_slot, uint k)
{
    cell_attributes a;
    a.albedo = a.normal = a.emission = vec3(0.0);
    a.double_sided = 0.0;
    a.weight = 0u;
    a.area = 0.0;
    uint slot = first_slot + k;
    if (((b.resting >> k) & 1u) != 0u)
        a = cell_attributes_unpack(uvec4(static_surface[slot], tree.light.x > 0.0 ? static_emission[slot] : uvec2(0u)));
    if (((b.moving >> k) & 1u) != 0u)
        a = cell_attributes_merge(a, cell_attributes_unpack(dynamic_cells[b.first_moving + k]));
    return a;
}

// The same of the leaf at `slot` with mask bit `code`.
cell_attributes cell_load(uint slot, uint code, uint layer_words, uint dynamic_room)
{
    return cell_of_block(cell_block_of(code >> 3, layer_words, dynamic_room), slot & ~7u, slot & 7u);
}
