// Marks the cells of stale bricks that static voxels cover.
layout(local_size_x = 64) in;

#include "shaders/include/stale_voxel.glsl"
#include "shaders/include/morton.glsl"

layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 6) buffer mask_block { uint mask[]; };

void main()
{
    kd_voxel_segment segment;
    uint i;
    if (!stale_voxel(segment, i))
        return;
    rigid_voxel v = rigid_voxel_load(segment, i);
    if (!v.inside)
        return;
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c);
    for (uint k = 0u; k < 8u; k++) {
        ivec3 cell = splat_cell(v.place, k);
        if (splat_weight(v.place, k) < SPLAT_MIN_WEIGHT || !splat_owned(c, cell))
            continue;
        uint bit = first + morton_encode(cell_wrap(c, cell)), brick = bit >> (3u * tree.info.w);
        if ((stale[brick >> 5] >> (brick & 31u) & 1u) != 0u)
            atomicOr(mask[bit >> 5], 1u << (bit & 31u));
    }
}
