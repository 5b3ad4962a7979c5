// Static cells that come anew. One invocation a stale patch.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: patches marked, y: words of a cascade's leaf parents, z: first patch marked
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer fresh_block { uint fresh[]; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };

void main()
{
    uint n = linear_index(), cells = 0u;
    if (n >= pass.x)
        return;
    for (uint i = 0u; i < 8u; i++)
        cells += uint(bitCount(fresh[n * 8u + i]));
    if (cells != 0u)
        atomicAdd(counters[KD_COUNT_CENSUS_CELLS + stale[stale_at.patches + pass.z + n] / pass.y], cells);
}
