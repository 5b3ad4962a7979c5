// Voxelization, pass 1: set the bit of every cell of the chunk that a triangle touches.
layout(local_size_x = 64) in;

layout(std430, binding = 4) buffer mask_block { uint mask[]; };

void fragment(uint triangle, uvec3 cell, vec3 bary);

#include "shaders/include/linear.glsl"
#include "shaders/voxel_cache/triangle.glsl"
#include "shaders/voxel_cache/surface.glsl"
#include "shaders/voxel_cache/chunk_cell.glsl"

void fragment(uint triangle, uvec3 cell, vec3 bary)
{
    if (material.emissive.a >= 0.0 && !fragment_opaque(fragment_load(triangle, bary)))
        return;
    uint bit = chunk_bit(pass.chunk_size.xyz, cell);
    atomicOr(mask[bit >> 5], 1u << (bit & 31u));
}

void main()
{
    uint column = linear_index();
    if (column < pass.chunk_size.w)
        visit_column(column);
}
