// Numbers the stale patches by their places on the list.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: patches
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 0) buffer stale_block { uint stale[]; };

void main()
{
    uint n = linear_index();
    if (n < pass.x)
        stale[stale_at.slots + stale[stale_at.patches + n]] = n;
}
