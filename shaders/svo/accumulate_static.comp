// The same for static voxels that lie in stale bricks, straight from the cache. Only cells that were marked this frame have
// bits in the mask.
layout(local_size_x = 64) in;

#include "shaders/include/stale_voxel.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/cell_sums.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first cell of this round, y: cells of it, z: where the ranks begin
layout(std430, binding = 5) readonly buffer color_block { uint color[]; };
layout(std430, binding = 6) readonly buffer fresh_block { uint fresh[]; }; // mask, then ranks

void main()
{
    kd_voxel_segment segment;
    uint i;
    if (!stale_voxel(segment, i))
        return;
    rigid_voxel r = rigid_voxel_load(segment, i);
    uint n = segment.first + i;
    voxel_share v = voxel_share_of(color[n], shape[n].y >> 24, r.normal, objects[segment.object].emission.rgb);
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c);
    for (uint corners = r.inside ? splat_corners(r.place, c) : 0u; corners != 0u; corners &= corners - 1u) {
        uint k = uint(findLSB(corners)), bit = first + morton_encode(cell_wrap(c, splat_cell(r.place, k)));
        if (!stale_brick(bit >> (3u * tree.info.w)))
            continue;
        uint at = stale_place(bit), rank = rank_below(fresh[pass.z + (at >> 5)], fresh[at >> 5], at);
        if (rank - pass.x < pass.y)
            sums_add(rank - pass.x, splat_weight(r.place, k), v);
    }
}
