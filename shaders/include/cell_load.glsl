// What a leaf cell of the tree holds, from the buffers of both layers.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/cell_attributes.glsl"

layout(std430, binding = 1) readonly buffer masks_block { uint masks[]; };         // of the static layer
layout(std430, binding = 2) readonly buffer moving_block { uint moving[]; };       // of the dynamic layer; its leaf parents, mask and ranks
layout(std430, binding = 3) readonly buffer surface_block { uvec2 static_surface[]; };  // of static cells, beside their leaves
layout(std430, binding = 4) readonly buffer emission_block { uvec2 static_emission[]; }; // where anything glows
layout(std430, binding = 5) readonly buffer dynamic_block { uvec4 dynamic_cells[]; };

// Attributes of the leaf at `slot` with mask bit `code`; weight 0 when it is empty. layer_words: of a layer's mask,
// dynamic_room: leaf parents with room for dynamic cells; 0 when nothing moves.
cell_attributes cell_load(uint slot, uint code, uint layer_words, uint dynamic_room)
{
    cell_attributes a;
    a.albedo = a.normal = a.emission = vec3(0.0);
    a.double_sided = 0.0;
    a.weight = 0u;
    a.area = 0.0;
    uint word = code >> 5, bit = 1u << (code & 31u);
    uint s = masks[word], d = dynamic_room != 0u ? moving[word] : 0u;
    if ((s & bit) != 0u)
        a = cell_attributes_unpack(uvec4(static_surface[slot], tree.light.x > 0.0 ? static_emission[slot] : uvec2(0u)));
    if ((d & bit) != 0u) {
        uint parent = code >> 3, at = layer_words + (parent >> 5);
        uint rank = rank_below(moving[at + (layer_words >> 3)], moving[at], parent);
        if (rank < dynamic_room)
            a = cell_attributes_merge(a, cell_attributes_unpack(dynamic_cells[rank * 8u + (code & 7u)]));
    }
    return a;
}
