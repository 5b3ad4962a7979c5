// Marks the cells of stale bricks that static voxels cover.
layout(local_size_x = 64) in;

#include "shaders/include/stale_voxel.glsl"
#include "shaders/include/morton.glsl"

layout(std430, binding = 5) buffer fresh_block { uint fresh[]; };

void main()
{
    kd_voxel_segment segment;
    uint i;
    if (!stale_voxel(segment, i))
        return;
    rigid_voxel v = rigid_voxel_load(segment, i);
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c);
    for (uint corners = v.inside ? splat_corners(v.place, c) : 0u; corners != 0u; corners &= corners - 1u) {
        uint bit = first + morton_encode(cell_wrap(c, splat_cell(v.place, uint(findLSB(corners)))));
        if (!stale_brick(bit >> (3u * tree.info.w)))
            continue;
        uint at = stale_place(bit);
        atomicOr(fresh[at >> 5], 1u << (at & 31u));
    }
}
