// Arguments of a dispatch over the list of groups: one work group each, in rows.
layout(local_size_x = 1) in;

#include "shaders/shared/voxel.h"

layout(std430, binding = 0) buffer list_block { uint list[]; };

void main()
{
    list[0] = min(list[3], KD_GROUP_ROW);
    list[1] = (list[3] + KD_GROUP_ROW - 1u) / KD_GROUP_ROW;
    list[2] = 1u;
}
