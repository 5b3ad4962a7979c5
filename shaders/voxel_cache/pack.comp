// Voxelization, pass 3: one invocation a mask word turns sums into cached voxels, in the order of their cells. A voxel without
// fragments is inside of a filled mesh: it takes its colour from a surface voxel before it (there is one to its left), and no side.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/linear.glsl"
#include "shaders/include/voxel_pack.glsl"
#include "shaders/voxel_cache/chunk_cell.glsl"

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

float mean(uint at, uint number)
{
    float sum = float(sums[at + 8u + number]) * 4294967296.0 + float(sums[at + 1u + number]);
    return sum / (65535.0 * float(max(sums[at], 1u)));
}

void pack(uint voxel, uint from, uint bit)
{
    uvec3 cell = chunk_cell(pass.chunk_size.xyz, bit);
    uint at = from * 16u;
    vec3 albedo = vec3(mean(at, 0u), mean(at, 1u), mean(at, 2u));
    vec3 normal = vec3(mean(at, 3u), mean(at, 4u), mean(at, 5u)) * 2.0 - 1.0;
    uint emission = uint(round(mean(at, 6u) * 255.0));
    if (from != voxel) {
        normal = vec3(0.0);
        emission = 0u;
    }
    uint out_at = pass.dest.x + voxel;
    shape[out_at] = uvec2(cell_pack(cell), snorm8_pack(normal) | emission << 24);
    uint area = min(uint(round(float(sums[voxel * 16u + 15u]) * (KD_AREA_ONE / 4096.0))), 127u);
    color[out_at] = albedo_pack(albedo) | (pass.dest.w & 1u) << 24 | area << 25;
}

void main()
{
    uint word = linear_index();
    if (word >= pass.chunk_size.w)
        return;
    uint bits = mask[word], voxel = ranks[word], from = voxel;
    if (bits == 0u)
        return;
    while (from > 0u && sums[from * 16u] == 0u)
        from--;
    while (bits != 0u) {
        uint low = uint(findLSB(bits));
        from = sums[voxel * 16u] != 0u ? voxel : from;
        pack(voxel, from, word * 32u + low);
        bits &= bits - 1u;
        voxel++;
    }
}
