// What a channel shows of a cell.

#include "shaders/debug_view/tree_means.glsl"
#include "shaders/debug_view/show.glsl"

layout(std430, binding = 6) readonly buffer means_block { uint means[]; };

vec3 mean_of(uint entry, uint first, bool is_signed)
{
    uint at = entry * KD_MEAN_WORDS;
    vec3 sum;
    for (uint k = 0u; k < 3u; k++)
        sum[k] = is_signed ? float(int(means[at + first + k])) : float(means[at + first + k]);
    return sum / (KD_MEAN_ONE * max(float(means[at]), 1.0));
}

vec3 cell_attribute(cell_place at, uint channel)
{
    bool normal = channel == KD_SHOW_VOXEL_NORMAL;
    if (at.level == 0) {
        cell_attributes a = leaf_attributes(at.cascade, at.cell);
        return normal ? a.normal : a.albedo;
    }
    uint entry = mean_entry(at);
    return entry == KD_EMPTY ? vec3(0.0) : mean_of(entry, normal ? 4u : 1u, normal);
}

// seen: cell_seen of it, with matter; k: the finest cascade there
vec3 cell_show(cell_place at, int k, vec4 seen, uint channel)
{
    if (channel == KD_SHOW_RADIANCE)
        return seen.rgb / seen.a * tree.light.z;
    if (channel == KD_SHOW_OPACITY)
        return vec3(depth_opacity(seen.a));
    if (channel == KD_SHOW_CASCADE)
        return show_cascade(k);
    vec3 a = cell_attribute(at, channel);
    return channel == KD_SHOW_VOXEL_NORMAL ? show_normal(a) : a;
}
