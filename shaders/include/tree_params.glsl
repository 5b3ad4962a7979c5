#include "shaders/shared/bindings.h"
#include "shaders/shared/voxel.h"

layout(std140, binding = KD_BIND_TREE) uniform tree_block { kd_tree_params tree; };

// First bit of cascade c in a mask of leaf cells.
uint cascade_first_bit(uint c)
{
    return c << (3u * tree.info.z);
}

// Is a cell of cascade c inside the region that the next finer cascade covers? That one is its central half.
bool in_finer_cascade(uint c, ivec3 cell)
{
    int quarter = int(tree.info.y) / 4;
    return c > 0u && all(greaterThanEqual(cell, ivec3(quarter))) && all(lessThan(cell, ivec3(3 * quarter)));
}
