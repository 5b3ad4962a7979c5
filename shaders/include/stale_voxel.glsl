// The static voxel of this invocation: one of a group on the list that voxel_transform/cull.comp made.

#include "shaders/include/rigid_voxel.glsl"

layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 0) readonly buffer stale_block { uint stale[]; };

#include "shaders/include/stale.glsl"

// Segment and voxel of it; false beyond the list or the segment.
bool stale_voxel(out kd_voxel_segment segment, out uint i)
{
    uint local = gl_LocalInvocationIndex;
    uint entry = (gl_WorkGroupID.y * KD_GROUP_ROW + gl_WorkGroupID.x) * KD_GROUPS_AT_ONCE + local / KD_GROUP_VOXELS;
    bool listed = entry < stale[KD_STALE_COUNT];
    uint n = listed ? stale[stale_at.groups + entry] : 0u;
    segment = segments[n / KD_SEGMENT_GROUPS];
    i = n % KD_SEGMENT_GROUPS * KD_GROUP_VOXELS + local % KD_GROUP_VOXELS;
    return listed && i < segment.count;
}
