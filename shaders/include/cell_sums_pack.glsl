// Attributes of a cell from its sums (cell_sums.glsl).

#include "shaders/include/cell_pack.glsl"

layout(std430, binding = 1) readonly buffer sums_block { uint sums[]; };

uvec4 cell_attributes_of(uint cell, uint given_up)
{
    uint at = cell * KD_SUM_WORDS;
    uvec3 albedo = uvec3(sums[at + 1u], sums[at + 2u], sums[at + 3u]);
    ivec3 normal = ivec3(sums[at + 4u], sums[at + 5u], sums[at + 6u]);
    ivec3 axes = ivec3(sums[at + 13u], sums[at + 14u], sums[at + 15u]);
    uvec3 emission = uvec3(sums[at + 7u], sums[at + 8u], sums[at + 9u]);
    return uvec4(cell_pack_surface(sums[at], albedo, normal, axes, sums[at + 10u], given_up),
                 cell_pack_emission(sums[at], emission, sums[at + 11u], sums[at + 12u], given_up));
}
