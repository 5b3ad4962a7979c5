// Indirect arguments from the counters: groups of 64 over the nodes of each level, the leaf slots and the cells of layers.
// Besides, for the statistics, how the nodes of a level are spread over the cascades.
layout(local_size_x = 1) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents - 6, y: capacity of nodes a level, z: of dynamic, w: of static cells
layout(std140, binding = 1) uniform level_block { uvec4 first; uvec4 size; uvec4 cascades; }; // of the levels 6 … 9: first word of the ranks, words a cascade (0: no such level); x: cascades
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer ranks_block { uint ranks[]; };

void write_args(uint at, uint count)
{
    counters[at] = (count + 63u) / 64u;
    counters[at + 1u] = 1u;
    counters[at + 2u] = 1u;
}

void main()
{
    for (uint level = 0u; level < 4u; level++)
        write_args(KD_ARGS_LEVEL + 3u * level, min(counters[KD_COUNT_LEVEL + level], pass.y));
    write_args(KD_ARGS_LEAVES, 8u * min(counters[KD_COUNT_LEVEL + pass.x], pass.y));
    write_args(KD_ARGS_DYNAMIC, min(counters[KD_COUNT_DYNAMIC], pass.z));
    write_args(KD_ARGS_STATIC, min(counters[KD_COUNT_STATIC], pass.w));
    for (uint level = 0u; level < 4u; level++)
        for (uint c = 0u; c < cascades.x && size[level] != 0u; c++)
            counters[KD_COUNT_BEFORE + 4u * level + c] = ranks[first[level] + c * size[level]];
}
