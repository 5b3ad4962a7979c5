// Voxelization, pass 3: one invocation a mask word turns sums into cached voxels, in the order of their cells. A voxel without
// fragments is inside of a filled mesh: it takes its colour from the surface to its left, and no side.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/linear.glsl"
#include "shaders/include/voxel_pack.glsl"

layout(std140, binding = 0) uniform pass_block {
    vec4 chunk_origin;
    uvec4 chunk_size; // xyz: cells, w: mask words
    uvec4 source;
    uvec4 dest;       // x: first voxel, w: bit 0 double sided
} pass;

layout(std430, binding = 0) readonly buffer mask_block { uint mask[]; };
layout(std430, binding = 1) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 2) readonly buffer sums_block { uint sums[]; };
layout(std430, binding = 3) writeonly buffer shape_block { uvec2 shape[]; }; // cell, normal
layout(std430, binding = 4) writeonly buffer color_block { uint color[]; };

void pack(uint voxel, uint bit)
{
    uvec3 cell = uvec3(bit % pass.chunk_size.x, bit / pass.chunk_size.x % pass.chunk_size.y,
                       bit / (pass.chunk_size.x * pass.chunk_size.y));
    uint from = voxel;
    while (from > 0u && sums[from * 8u] == 0u)
        from--;
    uint at = from * 8u;
    float weight = float(max(sums[at], 1u));
    vec3 albedo = vec3(sums[at + 1u], sums[at + 2u], sums[at + 3u]) / (255.0 * weight);
    vec3 normal = vec3(int(sums[at + 4u]), int(sums[at + 5u]), int(sums[at + 6u])) / (127.0 * weight);
    uint emission = uint(round(float(sums[at + 7u]) / weight));
    if (from != voxel) {
        normal = vec3(0.0);
        emission = 0u;
    }
    uint out_at = pass.dest.x + voxel;
    shape[out_at] = uvec2(cell_pack(cell), snorm8_pack(normal) | emission << 24);
    color[out_at] = albedo_pack(albedo) | (pass.dest.w & 1u) << 24;
}

void main()
{
    uint word = linear_index();
    if (word >= pass.chunk_size.w)
        return;
    uint bits = mask[word], voxel = ranks[word];
    while (bits != 0u) {
        uint low = uint(findLSB(bits));
        pack(voxel, word * 32u + low);
        bits &= bits - 1u;
        voxel++;
    }
}
