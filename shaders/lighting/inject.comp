// Light enters the tree: every leaf gets the direct light of all lights through their shadow maps, reflected diffusely, and
// its own emission, and sends out again what the dense cell round it has gathered. One invocation a leaf slot, eight siblings side by side.
// Source: Crassin 2011 and Yalciner 2016, section 3.3.3 (injection into leaves), here for lights of all kinds.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/cell_load.glsl"
#include "shaders/include/tree_node.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/bounce.glsl"
#include "shaders/include/emitters_params.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 bounce; }; // x: level of the leaf parents, y: words of a layer's mask, z: capacity of the dynamic cells; bounce.x: frame, y: age from which entries are dropped (0: none are sent out), z: 1 lets light of lamps in
layout(std430, binding = 6) buffer leaves_block { uvec2 leaves[]; };
layout(binding = KD_UNIT_BOUNCE) uniform usamplerBuffer entries;                  // shaders/shared/bounce.h

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

// Irradiance / pi that the cell round a leaf has gathered, stored units: by the squares of the normal's parts from the sides
// that it faces; from all sides alike where normals of many directions meet.
vec3 bounced_light(cell_attributes a, uint c, ivec3 cell)
{
    if (bounce.y == 0u)
        return vec3(0.0);
    ivec3 world_cell = bounce_world_cell(c, cell >> int(tree.info.w));
    int at = int(bounce_first_entry(c, world_cell));
    if (texelFetch(entries, at + 7).r != bounce_identity(world_cell) || bounce.x - texelFetch(entries, at + 6).r > bounce.y)
        return vec3(0.0);
    float gathered = length(a.normal);
    vec3 n = gathered > 1e-3 ? a.normal / gathered : vec3(0.0), square = n * n, sum = vec3(0.0);
    float directed = min(gathered * 2.0, 1.0), weight = 0.0;
    for (int side = 0; side < 6; side++) {
        float towards = (side & 1) == 0 ? n[side >> 1] : -n[side >> 1];
        float faces = square[side >> 1] * (towards >= 0.0 ? 1.0 - 0.5 * a.double_sided : 0.5 * a.double_sided);
        float w = mix(1.0 / 6.0, faces, directed);
        sum += w * rgb9e5_unpack(texelFetch(entries, at + side).r);
        weight += w;
    }
    return sum / weight;
}

uvec2 leaf_of(uint slot, uint code)
{
    cell_attributes a = cell_load(slot, code, pass.y, pass.z);
    if (a.weight == 0u)
        return uvec2(0u);
    uint c = code >> (3u * tree.info.z);
    ivec3 cell = cell_unwrap(c, morton_decode(code & ((1u << (3u * tree.info.z)) - 1u)));
    float span = tree.cascade[c].w;
    vec3 p_ws = tree.cascade[c].xyz + (vec3(cell) + 0.5) * span;
    vec3 lamps = bounce.z != 0u ? direct_light(a, p_ws, span) : vec3(0.0);
    // Strictly, cells with surfaces of opposite sides reflect nothing: what lights one side would be seen from the other.
    vec3 albedo = a.albedo;
    if (tree_is_strict())
        albedo *= (1.0 - a.double_sided) * smoothstep(0.9, 0.97, length(a.normal));
    vec3 emission = emitters.info.x == 0u ? a.emission * tree.light.x : vec3(0.0); // emitters.glsl lights by it
    vec3 radiance = tree.light.y * (albedo * (1.0 / 3.14159265) * lamps + emission);
    radiance += albedo * bounced_light(a, c, cell);
    float depth = FULL_DEPTH * min(float(a.weight) / 256.0, 1.0);
    return leaf_pack(leaf_value(radiance, a.normal, depth, a.double_sided > 0.5));
}

void main()
{
    uint parent = linear_index() >> 3, k = linear_index() & 7u;
    if (parent >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.x] + parent];
    if (code == KD_EMPTY)
        return;
    uint slot = parent * 8u + k;
    uvec2 leaf = leaf_of(slot, code * 8u + k);
    if (leaf == leaves[slot])
        return;
    leaves[slot] = leaf;
    if (pass.x == 0u)
        book_change_dense(code);
    else
        book_change_node(pass.x, parent);
}
