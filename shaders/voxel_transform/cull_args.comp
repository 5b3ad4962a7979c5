// Arguments of a dispatch over the list of groups: so many to a work group, in rows. Each voxel of a group has an entry.
layout(local_size_x = 1) in;

#include "shaders/shared/voxel.h"

layout(std430, binding = 0) buffer stale_block { uint stale[]; };

void main()
{
    uint work_groups = (stale[KD_STALE_COUNT] + KD_GROUPS_AT_ONCE - 1u) / KD_GROUPS_AT_ONCE;
    stale[0] = min(work_groups, KD_GROUP_ROW);
    stale[1] = (work_groups + KD_GROUP_ROW - 1u) / KD_GROUP_ROW;
    stale[2] = 1u;
    stale[KD_STALE_ENTRIES] = stale[KD_STALE_COUNT] * KD_GROUP_VOXELS;
}
