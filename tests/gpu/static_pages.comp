// Static voxels as page voxels, which the octree's passes make on the way and do not keep.
layout(local_size_x = 64) in;

#include "shaders/include/rigid_voxel_load.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots
layout(std430, binding = 5) writeonly buffer voxels_block { uint voxels[]; };

void main()
{
    uint n = linear_index();
    if (n >= pass.x * KD_SEGMENT_VOXELS)
        return;
    kd_voxel_segment segment = segments[n / KD_SEGMENT_VOXELS];
    if (n % KD_SEGMENT_VOXELS >= segment.count)
        return;
    rigid_voxel v = rigid_voxel_load(segment, n % KD_SEGMENT_VOXELS);
    voxels[n * KD_PAGE_WORDS] = v.inside ? splat_pack_cell(v.place) : KD_NO_VOXEL;
    voxels[n * KD_PAGE_WORDS + 1u] = splat_pack_fraction(v.place);
    voxels[n * KD_PAGE_WORDS + 2u] = rigid_voxel_load_normal(segment, n % KD_SEGMENT_VOXELS);
    voxels[n * KD_PAGE_WORDS + 3u] = 0u;
}
