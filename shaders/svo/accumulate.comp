// Adds the attributes of the dynamic layer's page voxels to the cells that they cover. The cell's place in the sums is the rank
// of its mask bit.
layout(local_size_x = 128) in;

#include "shaders/include/splat.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/cell_sums.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first cell of this round, y: cells of it, z: where the ranks begin
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 2) readonly buffer shape_block { uvec2 shape[]; };
layout(std430, binding = 3) readonly buffer color_block { uint color[]; };
layout(std430, binding = 4) readonly buffer voxels_block { uint voxels[]; };
layout(std430, binding = 5) readonly buffer moving_block { uint moving[]; }; // mask, then ranks

void main()
{
    uint slot = gl_WorkGroupID.y, i = gl_GlobalInvocationID.x;
    kd_voxel_segment segment = segments[slot];
    if (i >= segment.count)
        return;
    uint from = (slot * KD_SEGMENT_VOXELS + i) * 3u;
    uint cell_word = voxels[from];
    if (cell_word == KD_NO_VOXEL)
        return;
    splat s = splat_unpack(cell_word, voxels[from + 1u]);
    uint n = segment.first + i;
    voxel_share v = voxel_share_of(color[n], shape[n].y >> 24, voxels[from + 2u], objects[segment.object].emission.rgb);
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c);
    for (uint corners = splat_corners(s, c); corners != 0u; corners &= corners - 1u) {
        uint k = uint(findLSB(corners)), bit = first + morton_encode(cell_wrap(c, splat_cell(s, k)));
        uint rank = rank_below(moving[pass.z + (bit >> 5)], moving[bit >> 5], bit);
        if (rank - pass.x < pass.y)
            sums_add(rank - pass.x, splat_weight(s, k), v);
    }
}
