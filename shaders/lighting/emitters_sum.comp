// Adds up the leaves that glow by blocks (shaders/shared/emitters.h). One invocation a leaf parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/cell_load.glsl"
#include "shaders/shared/emitters.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: capacity of the dynamic cells
layout(std430, binding = 6) buffer sums_block { uint sums[]; };

// Area that shows, in faces: that of the mesh, but no more than a cell can show. What a mesh has beyond that hides in itself.
// One plane of unit normal n cuts at most a face over its largest part out of a cell; bent surfaces fill |nx| + |ny| + |nz|
// cells a face; where normals cancel two sides of something thin are in the cell, turned anyhow.
float area_shown(cell_attributes a)
{
    float gathered = length(a.normal), coverage = min(float(a.weight) / 256.0, 1.0);
    vec3 n = abs(a.normal);
    float flat_one = gathered / max(n.x, max(n.y, max(n.z, 1e-3))), bent = gathered / max(n.x + n.y + n.z, 1e-3);
    float most = mix(mix(4.0 / 3.0, bent, min(gathered, 1.0)), flat_one, smoothstep(0.85, 0.98, gathered));
    return min(a.area, coverage * most);
}

// edge: 1, or more where a cell stands for others
void add(uint at, cell_attributes a, uvec3 cell, uint edge)
{
    float area = area_shown(a), faces = area * float(edge * edge);
    uvec3 power = uvec3(round(a.emission * (faces * KD_EMITTER_AREA_ONE * KD_EMITTER_RADIANCE_ONE)));
    float brightest = max(a.emission.r, max(a.emission.g, a.emission.b));
    uint weight = uint(clamp(round(area * brightest * KD_EMITTER_AREA_ONE), 1.0, KD_EMITTER_AREA_ONE));
    uvec3 first = weight * (2u * cell + edge); // half cells
    uvec3 second = weight * (cell * cell + edge * cell + edge * edge / 4u);
    float gathered = max(length(a.normal), 1e-3);
    ivec3 normal = ivec3(round(a.normal * (min(gathered * 1.1, 1.0) / gathered * 127.0))) * int(weight);
    for (int k = 0; k < 3; k++) {
        atomicAdd(sums[at + uint(k)], power[k]);
        atomicAdd(sums[at + 3u + uint(k)], first[k]);
        atomicAdd(sums[at + 6u + uint(k)], second[k]);
        atomicAdd(sums[at + 9u + uint(k)], uint(normal[k]));
    }
    atomicAdd(sums[at + 12u], uint(round(a.double_sided * float(weight))));
    atomicAdd(sums[at + 13u], weight);
    atomicAdd(sums[at + 14u], uint(round(faces * KD_EMITTER_AREA_ONE)));
}

// Cells of a parent that may glow, a bit each: those that move, and those at rest that were seen to.
uint cells_to_ask(cell_parent parent)
{
    uint bits = parent.moves;
    for (uint k = 0u; k < 8u; k++)
        bits |= block_has(parent.block, k) && static_emission[block_slot(parent.block, k)].x != 0u ? 1u << k : 0u;
    return bits;
}

// Of what is thin no side shows more than the other.
cell_attributes without_side(cell_attributes a)
{
    if (a.thin && a.double_sided < 0.5)
        a.normal = vec3(0.0);
    return a;
}

void main()
{
    uint parent = linear_index();
    if (parent >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.x] + parent];
    if (code == KD_EMPTY)
        return;
    cell_parent p = cell_parent_of(parent, code, pass.y);
    uint bits = cells_to_ask(p);
    if (bits == 0u)
        return;
    uint c = (code * 8u) >> (3u * tree.info.z);
    uvec3 low = uvec3(cell_unwrap(c, morton_decode((code * 8u) & ((1u << (3u * tree.info.z)) - 1u))));
    uint shift = tree.info.w + uint(KD_EMITTER_BLOCK_LOG2);
    uvec3 of = low >> shift, within = low & ((1u << shift) - 1u);
    uint at = ((c * uint(KD_EMITTER_BLOCKS) + of.z) * uint(KD_EMITTER_BLOCKS) + of.y) * uint(KD_EMITTER_BLOCKS) + of.x;
    do {
        uint k = uint(findLSB(bits));
        cell_attributes a = without_side(cell_load(p, k));
        if (a.weight != 0u && any(greaterThan(a.emission, vec3(0.0))))
            add(at * KD_EMITTER_WORDS, a, within + (uvec3(k, k >> 1, k >> 2) & 1u), 1u << cascade_given_up(c));
        bits &= bits - 1u;
    } while (bits != 0u);
}
