// Sums of albedo and normal over the leaves below each cell of the level that is shown, since the tree itself keeps radiance
// and depth alone above its leaves. One invocation a leaf parent, whose eight leaves lie in one such cell.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/debug_view/tree_means.glsl"

layout(std430, binding = 6) buffer means_block { uint means[]; };

void add(uint entry, uint first, vec3 value, float weight)
{
    ivec3 v = ivec3(round(value * (KD_MEAN_ONE * weight)));
    for (uint k = 0u; k < 3u; k++)
        if (v[k] != 0)
            atomicAdd(means[entry * KD_MEAN_WORDS + first + k], uint(v[k]));
}

void main()
{
    uint parent = linear_index();
    if (parent >= params.tree.z)
        return;
    uint code = book[places.codes[params.tree.w] + parent];
    if (code == KD_EMPTY)
        return;
    int c = int((code * 8u) >> (3u * tree.info.z)), lod = max(int(params.view.z), tree_finest(c));
    if (lod == c)
        return; // its leaves are shown themselves
    vec3 albedo = vec3(0.0), normal = vec3(0.0);
    float weight = 0.0;
    for (uint k = 0u; k < 8u; k++) {
        cell_attributes a = cell_load(cell_parent_of(parent, code, params.tree.y), k);
        float w = min(float(a.weight), 256.0);
        albedo += w * a.albedo;
        normal += w * a.normal;
        weight += w;
    }
    if (weight <= 0.0)
        return;
    ivec3 cell = cell_unwrap(uint(c), morton_decode((code * 8u) & ((1u << (3u * tree.info.z)) - 1u)));
    uint entry = mean_entry(cell_at(c, lod, tree.cascade[c].xyz + (vec3(cell) + 1.0) * tree.cascade[c].w));
    if (entry == KD_EMPTY)
        return;
    float share = clamp(round(weight * (KD_MEAN_WEIGHT / 2048.0)), 1.0, KD_MEAN_WEIGHT);
    atomicAdd(means[entry * KD_MEAN_WORDS], uint(share));
    add(entry, 1u, albedo / weight, share);
    add(entry, 4u, normal / weight, share);
}
