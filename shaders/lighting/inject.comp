// Light enters the tree: every leaf gets the direct light of all lights through their shadow maps, reflected diffusely, and
// its own emission. One invocation a leaf slot, eight siblings side by side.
// Source: Crassin 2011 and Yalciner 2016, section 3.3.3 (injection into leaves), here for lights of all kinds.
layout(local_size_x = 64) in;

#include "shaders/include/tree_params.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/cell_attributes.glsl"
#include "shaders/include/tree_node.glsl"
#include "shaders/include/lights.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 layer; }; // x: counter of the leaf parents, y: their capacity, z: first list entry; layer.x: words of a layer's mask, yz: capacity of static, dynamic cells
layout(std430, binding = 0) readonly buffer list_block { uint list[]; };
layout(std430, binding = 1) readonly buffer masks_block { uint masks[]; };
layout(std430, binding = 2) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 3) readonly buffer static_block { uvec4 static_cells[]; };
layout(std430, binding = 4) readonly buffer dynamic_block { uvec4 dynamic_cells[]; };
layout(std430, binding = 5) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 6) writeonly buffer leaves_block { uvec2 leaves[]; };

// Attributes of a cell from both layers; weight 0 when it is empty.
cell_attributes load_cell(uint code)
{
    cell_attributes a, b;
    a.albedo = a.normal = a.emission = vec3(0.0);
    a.double_sided = 0.0;
    a.weight = 0u;
    uint word = code >> 5, bit = 1u << (code & 31u);
    uint s = masks[word], d = masks[layer.x + word];
    if ((s & bit) != 0u) {
        uint rank = ranks[word] + uint(bitCount(s & (bit - 1u)));
        if (rank < layer.y)
            a = cell_attributes_unpack(static_cells[rank]);
    }
    if ((d & bit) != 0u) {
        uint rank = ranks[layer.x + word] + uint(bitCount(d & (bit - 1u)));
        if (rank < layer.z) {
            b = cell_attributes_unpack(dynamic_cells[rank]);
            a = cell_attributes_merge(a, b);
        }
    }
    return a;
}

// Cosine that the cell's surfaces show to the light. Where normals of many directions meet, the mean of a sphere's lit
// side takes over: a quarter of what faces it.
float facing(cell_attributes a, vec3 to_light)
{
    float gathered = length(a.normal);
    if (gathered < 1e-3)
        return 0.25;
    float d = dot(a.normal, to_light) / gathered;
    float cosine = mix(max(d, 0.0), abs(d), a.double_sided);
    return mix(0.25, cosine, min(gathered * 2.0, 1.0));
}

vec3 direct_light(cell_attributes a, vec3 p_ws, float span)
{
    vec3 sum = vec3(0.0);
    float gathered = length(a.normal);
    vec3 n = gathered > 1e-3 ? a.normal / gathered : vec3(0.0);
    for (uint i = 0u; i < light_count(); i++) {
        vec3 to_light;
        vec3 e = light_sample(i, p_ws, to_light);
        float cosine = facing(a, to_light);
        if (cosine * max(e.r, max(e.g, e.b)) <= 0.0)
            continue;
        vec3 side = dot(n, to_light) < 0.0 ? -n : n;
        sum += e * cosine * light_shadow_voxel(i, p_ws + 0.5 * span * to_light, side, span);
    }
    return sum;
}

void main()
{
    uint slot = gl_GlobalInvocationID.x, parent = slot >> 3;
    if (parent >= min(counters[pass.x], pass.y))
        return;
    uint code = list[pass.z + parent] * 8u + (slot & 7u);
    cell_attributes a = load_cell(code);
    if (a.weight == 0u) {
        leaves[slot] = uvec2(0u);
        return;
    }
    uint c = code >> (3u * tree.info.z);
    uvec3 cell = morton_decode(code & ((1u << (3u * tree.info.z)) - 1u));
    float span = tree.cascade[c].w;
    vec3 p_ws = tree.cascade[c].xyz + (vec3(cell) + 0.5) * span;
    vec3 radiance = tree.light.y * (a.albedo * (1.0 / 3.14159265) * direct_light(a, p_ws, span) + a.emission * tree.light.x);
    float depth = FULL_DEPTH * min(float(a.weight) / 256.0, 1.0);
    leaves[slot] = leaf_pack(leaf_value(radiance, a.normal, depth, a.double_sided > 0.5));
}
