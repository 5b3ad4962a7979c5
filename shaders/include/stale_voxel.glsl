// The static voxel of this invocation: one of a group on the list that voxel_transform/cull.comp made.

#include "shaders/include/rigid_voxel.glsl"

layout(std430, binding = 0) readonly buffer list_block { uint list[]; }; // arguments and count, then group numbers

// Segment and voxel of it; false beyond the list or the segment.
bool stale_voxel(out kd_voxel_segment segment, out uint i)
{
    uint entry = gl_WorkGroupID.y * KD_GROUP_ROW + gl_WorkGroupID.x;
    bool listed = entry < list[3];
    uint n = listed ? list[4u + entry] : 0u;
    segment = segments[n / KD_SEGMENT_GROUPS];
    i = n % KD_SEGMENT_GROUPS * KD_GROUP_VOXELS + gl_LocalInvocationIndex;
    return listed && i < segment.count;
}
