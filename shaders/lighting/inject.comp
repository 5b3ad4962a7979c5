// Light enters the tree: every leaf gets the direct light of all lights through their shadow maps, reflected diffusely, and
// its own emission, and sends out again what the dense cell round it has gathered. One invocation a leaf parent goes over its
// leaves: what they share is read once, and on software drivers none of them waits for empty ones.
// DIRECTIONAL and LOCAL (kinds of light there are) are known when compiling, as in shaders/include/shade.glsl.
// Source: Crassin 2011 and Yalciner 2016, section 3.3.3 (injection into leaves), here for lights of all kinds.
layout(local_size_x = 64) in;

#define KD_LEAVES_ACCESS

#include "shaders/include/linear.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/cell_load.glsl"
#include "shaders/include/tree_node.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/bounce.glsl"
#include "shaders/include/color.glsl"
#include "shaders/include/emitters_params.glsl"

// pass.x: level of the leaf parents, y: capacity of the dynamic cells, z: number of this run; bounce.x: frame, y: age from which
// entries are dropped (0: none are sent out), z: 1 lets light of lamps in
layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 bounce; };
layout(std430, binding = 6) readonly buffer open_block { float open[]; }; // of local lights: enclosed.comp
layout(binding = KD_UNIT_BOUNCE) uniform usamplerBuffer entries;          // shaders/shared/bounce.h

// Where a leaf's light arrives.
struct lit_leaf {
    vec3 p_ws, normal;     // normal: unit, or 0
    float span, directed;  // directed: 0 where normals of many directions meet, 1 where they agree
    float double_sided;
    bool two_sides;        // of which `normal` is one
};

// Opposite sides of something thin are lit each for itself, those of a double-sided sheet too: its cones meet its own cells from
// behind, and would light it by what shines on its front.
lit_leaf lit_leaf_of(cell_attributes a, vec3 p_ws, float span)
{
    float gathered = length(a.normal);
    vec3 n = gathered > 1e-3 ? a.normal / gathered : vec3(0.0);
    float directed = gathered > 1e-3 ? min(gathered * 2.0, 1.0) : 0.0;
    return lit_leaf(p_ws, n, span, directed, a.thin ? 0.0 : a.double_sided, a.thin);
}

// Cosine that the cell's surfaces show to the light. Where normals of many directions meet, the mean of a sphere's lit
// side takes over: a quarter of what faces it. A light that is shut in gives nothing to cells of both sides.
float facing(lit_leaf l, vec3 to_light, float is_open)
{
    float d = dot(l.normal, to_light), cosine = mix(max(d, 0.0), abs(d), l.double_sided);
    return mix(0.25 * is_open, l.two_sides ? cosine * is_open : cosine, l.directed);
}

// Where a leaf asks for its shadow: lifted off its own surface.
vec3 shadow_point(lit_leaf l, vec3 to_light)
{
    vec3 side = dot(l.normal, to_light) < 0.0 ? -l.normal : l.normal;
    return l.p_ws + l.span * (0.5 * to_light + side);
}

vec3 direct_light(lit_leaf l)
{
    uint i = 0u;
    vec3 to_light, sum = vec3(0.0);
#ifdef DIRECTIONAL
    do {
        vec3 e = light_sample(i, l.p_ws, to_light);
        sum += e * (facing(l, to_light, 1.0) * light_shadow_voxel_directional(i, shadow_point(l, to_light)));
        i++;
    } while (i < light_directional_count());
#endif
#ifdef LOCAL
    do {
        vec3 e = light_sample(i, l.p_ws, to_light);
        sum += e * (facing(l, to_light, open[i]) * light_shadow_voxel_local(i, shadow_point(l, to_light)));
        i++;
    } while (i < light_count());
#endif
    return sum;
}

// Irradiance / pi that the dense cell round a leaf parent has gathered on its six sides, stored units.
void bounced_sides(uint c, ivec3 dense_cell, out vec3 sides[6])
{
    ivec3 world_cell = bounce_world_cell(c, dense_cell);
    int at = int(bounce_first_entry(c, world_cell));
    uint kept = texelFetch(entries, at + 7).r, identity = bounce_identity(world_cell);
    bool holds = bounce.y != 0u && bounce_is_of(kept, identity) && bounce.x - texelFetch(entries, at + 6).r <= bounce.y;
    float unit = bounce_in_unit(kept, identity);
    for (int side = 0; side < 6; side++)
        sides[side] = holds ? unit * rgb9e5_unpack(texelFetch(entries, at + side).r) : vec3(0.0);
}

// What of it a leaf gets: by the squares of the normal's parts from the sides that it faces; from all sides alike where normals
// of many directions meet.
vec3 bounced_light(lit_leaf l, vec3 sides[6])
{
    vec3 square = l.normal * l.normal, sum = vec3(0.0);
    float weight = 0.0;
    for (int side = 0; side < 6; side++) {
        float towards = (side & 1) == 0 ? l.normal[side >> 1] : -l.normal[side >> 1];
        float faces = square[side >> 1] * (towards >= 0.0 ? 1.0 - 0.5 * l.double_sided : 0.5 * l.double_sided);
        float w = mix(1.0 / 6.0, faces, l.directed);
        sum += w * sides[side];
        weight += w;
    }
    return sum / weight;
}

// What a leaf sends out, stored units.
vec3 radiance_of(cell_attributes a, lit_leaf l, vec3 albedo, vec3 sides[6])
{
    vec3 lamps = bounce.z != 0u ? direct_light(l) : vec3(0.0);
    vec3 emission = emitters.info.x == 0u ? a.emission * tree.light.x : vec3(0.0); // emitters.glsl lights by it
    return tree.light.y * (albedo * (1.0 / 3.14159265) * lamps + emission) + albedo * bounced_light(l, sides);
}

// Strictly, cells with surfaces of opposite sides reflect nothing: what lights one side would be seen from the other.
vec3 albedo_of(cell_attributes a)
{
    float shown = a.thin ? 0.0 : (1.0 - a.double_sided) * smoothstep(0.9, 0.97, length(a.normal));
    return tree_is_strict() ? shown * a.albedo : a.albedo;
}

// front: what the side sends out that the normal points to, back: the other one
uvec2 leaf_of(cell_attributes a, vec3 front, vec3 back)
{
    float here = color_luminance(front), there = color_luminance(back);
    bool turned = there > here;
    float other = here == there ? 1.0 : min(here, there) / max(here, there);
    float depth = FULL_DEPTH * min(float(a.weight) / 256.0, 1.0);
    return leaf_pack(leaf_value(turned ? back : front, a.normal, depth, a.thin, other), turned);
}

// Leaves of a parent that hold something, or did. Returns a bit each.
uint leaves_to_do(cell_parent parent)
{
    uint bits = parent.block >> KD_BLOCK_BITS | parent.moves;
    for (uint k = 0u; k < 8u && parent.rank != KD_EMPTY; k++)
        bits |= uint(leaves[cell_slot(parent, k)] != uvec2(0u)) << k;
    return bits;
}

// Returns whether any of the leaves has changed.
bool light_leaves(cell_parent parent)
{
    uint code = parent.code, bits = leaves_to_do(parent), c = (code * 8u) >> (3u * tree.info.z);
    if (bits == 0u)
        return false;
    ivec3 low = cell_unwrap(c, morton_decode((code * 8u) & ((1u << (3u * tree.info.z)) - 1u)));
    float cell = tree.cascade[c].w, span = cell * float(1u << cascade_given_up(c)); // of what stands for others
    vec3 sides[6];
    bounced_sides(c, low >> int(tree.info.w), sides);
    bool changed = false, has_front = false;
    vec3 front = vec3(0.0);
    do {
        uint k = uint(findLSB(bits));
        uint slot = cell_slot(parent, k);
        cell_attributes a = cell_load(parent, k);
        vec3 p_ws = tree.cascade[c].xyz + vec3(low + (ivec3(k, k >> 1, k >> 2) & 1)) * cell + 0.5 * span;
        lit_leaf l = lit_leaf_of(a, p_ws, span);
        l.normal = has_front ? -l.normal : l.normal;
        vec3 radiance = radiance_of(a, l, albedo_of(a), sides);
        // A leaf of two sides takes two rounds, so that software drivers light no other leaf twice.
        if (l.two_sides && !has_front) {
            front = radiance;
            has_front = true;
        } else {
            uvec2 leaf = a.weight != 0u ? leaf_of(a, has_front ? front : radiance, radiance) : uvec2(0u);
            has_front = false;
            bits &= bits - 1u;
            if (leaf != leaves[slot]) {
                leaves[slot] = leaf;
                changed = true;
            }
        }
    } while (bits != 0u);
    return changed;
}

void main()
{
    uint parent = linear_index();
    if (parent >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.x] + parent];
    if (code == KD_EMPTY || !light_leaves(cell_parent_of(parent, code, pass.y)))
        return;
    counters[KD_COUNT_LIT] = pass.z; // the same number from all
    if (pass.x == 0u)
        book_change_dense(code);
    else
        book_change_node(pass.x, parent);
}
