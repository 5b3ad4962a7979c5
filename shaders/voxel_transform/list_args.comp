// Arguments of the dispatches over the lists of groups, one a kind: a work group each, in rows.
layout(local_size_x = 3) in;

#include "shaders/shared/voxel.h"

layout(std430, binding = 4) buffer work_block { uint work[]; };

void main()
{
    uint kind = gl_LocalInvocationIndex, groups = work[KD_MOVING_COUNT(kind)], at = KD_MOVING_ARGS(kind);
    work[at] = min(groups, KD_GROUP_ROW);
    work[at + 1u] = (groups + KD_GROUP_ROW - 1u) / KD_GROUP_ROW;
    work[at + 2u] = 1u;
}
