#include "shaders/shared/bindings.h"
#include "shaders/shared/voxel.h"

layout(std140, binding = KD_BIND_TREE) uniform tree_block { kd_tree_params tree; };

// Is it `light.leak=strict`?
bool tree_is_strict() { return tree.light.w != 0.0; }

// First bit of cascade c in a mask of leaf cells.
uint cascade_first_bit(uint c)
{
    return c << (3u * tree.info.z);
}

// Levels that cascade c has given up for want of room (systems/svo/shortage.c). Its cells are then 2^n leaf cells wide, and each
// lies where the leaf cell at its low corner would.
uint cascade_given_up(uint c)
{
    return tree.capacity.z >> (4u * c) & 15u;
}

// The bit, in a mask of leaf cells, of the cell that stands for this one.
uint cell_standing(uint c, uint bit)
{
    return bit & (0xFFFFFFFFu << (3u * cascade_given_up(c)));
}

// Place of a cell of cascade c, counted from its low corner, in a grid that does not move with the cascade: cells are kept
// under the world's own numbers modulo the resolution, so that what stays inside keeps its place (toroidal addressing,
// Losasso and Hoppe 2004 for clipmaps).
uvec3 cell_wrap(uint c, ivec3 cell)
{
    return uvec3(cell + tree.origin[c].xyz) & (tree.info.y - 1u);
}

ivec3 cell_unwrap(uint c, uvec3 wrapped)
{
    return ivec3((wrapped - uvec3(tree.origin[c].xyz)) & (tree.info.y - 1u));
}

// The same for cells of the dense level.
uvec3 dense_wrap(uint c, ivec3 cell)
{
    return uvec3(cell + (tree.origin[c].xyz >> int(tree.info.w))) & (uint(KD_DENSE) - 1u);
}

ivec3 dense_unwrap(uint c, uvec3 wrapped)
{
    return ivec3((wrapped - uvec3(tree.origin[c].xyz >> int(tree.info.w))) & (uint(KD_DENSE) - 1u));
}

// Is a cell of cascade c inside the region that the next finer cascade covers? That one is its central half.
bool in_finer_cascade(uint c, ivec3 cell)
{
    int quarter = int(tree.info.y) / 4;
    return c > 0u && all(greaterThanEqual(cell, ivec3(quarter))) && all(lessThan(cell, ivec3(3 * quarter)));
}
