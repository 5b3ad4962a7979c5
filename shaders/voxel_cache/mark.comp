// Voxelization, pass 1: set the bit of every cell of the chunk that a triangle touches, or of those that a thin voxelization
// takes. That one runs twice: what is thinner than a cell may miss all crosshairs, so a touched cell is taken, too, when
// neither it nor one of its six neighbours was the first time.
layout(local_size_x = 64) in;

layout(std430, binding = 4) buffer mask_block { uint mask[]; };
layout(std430, binding = 5) readonly buffer before_block { uint before[]; }; // the mask after the first time

void fragment(uint triangle, uvec3 cell, vec3 bary);

#include "shaders/include/linear.glsl"
bool keeps_cell(uvec3 cell, uint creases, vec3 a, vec3 b, vec3 c);

#include "shaders/voxel_cache/triangle.glsl"
#include "shaders/voxel_cache/thin.glsl"
#include "shaders/voxel_cache/surface.glsl"
#include "shaders/voxel_cache/chunk_cell.glsl"

void fragment(uint triangle, uvec3 cell, vec3 bary)
{
    if (material.emissive.a >= 0.0 && !fragment_opaque(fragment_load(triangle, bary)))
        return;
    uint bit = chunk_bit(pass.chunk_size.xyz, cell);
    atomicOr(mask[bit >> 5], 1u << (bit & 31u));
}

bool was_taken(ivec3 cell)
{
    if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(pass.chunk_size.xyz))))
        return false;
    uint bit = chunk_bit(pass.chunk_size.xyz, uvec3(cell));
    return (before[bit >> 5] >> (bit & 31u) & 1u) != 0u;
}

bool is_lone(ivec3 cell)
{
    bool taken = was_taken(cell);
    for (int k = 0; k < 3 && !taken; k++) {
        ivec3 step = ivec3(equal(ivec3(k), ivec3(0, 1, 2)));
        taken = was_taken(cell - step) || was_taken(cell + step);
    }
    return !taken;
}

bool keeps_cell(uvec3 cell, uint creases, vec3 a, vec3 b, vec3 c)
{
    if ((pass.dest.w & 4u) != 0u)
        return is_lone(ivec3(cell));
    return cuts_crosshair(vec3(cell) + 0.5, a, b, c) || holds_crease(vec3(cell), creases, a, b, c);
}

void main()
{
    uint column = linear_index();
    if (column < pass.chunk_size.w)
        visit_column(column);
}
