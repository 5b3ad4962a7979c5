// Attributes of the tree's cells: of leaves as they are, of cells above as sums over their leaves (means.comp).

#include "shaders/shared/debug_view.h"
#include "shaders/include/morton.glsl"
#include "shaders/include/cell_load.glsl"
#include "shaders/debug_view/tree_cell.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_debug_view_params params; };

// Entry of a cell that is no leaf in the sums of attributes; KD_EMPTY when there is no such node.
uint mean_entry(cell_place at)
{
    if (at.level < KD_SPARSE_LEVELS) {
        uint node = tree_node(at.cascade, at.level, tree_wrap(at.cascade, at.level, at.cell));
        return node == KD_EMPTY ? KD_EMPTY : uint(at.level - 1) * params.tree.z + node;
    }
    uint mip = uint(at.level - KD_SPARSE_LEVELS), size = uint(KD_DENSE) >> mip;
    uint first = uint(KD_SPARSE_LEVELS - 1) * params.tree.z;
    uint block = uint(KD_DENSE * KD_DENSE * KD_DENSE);
    first += mip == 0u ? uint(at.cascade) * block : uint(tree_cascades()) * block;
    for (uint m = 1u; m < mip; m++)
        first += block >> (3u * m);
    return first + (uint(at.cell.z) * size + uint(at.cell.y)) * size + uint(at.cell.x);
}

cell_attributes leaf_attributes(int c, ivec3 cell)
{
    cell = tree_wrap(c, 0, cell);
    uint parent = tree_parent(c, 0, cell), bit = cascade_first_bit(uint(c)) + morton_encode(uvec3(cell));
    cell_parent p = cell_parent(bit >> 3, 0u, KD_EMPTY, 0u);
    if (parent != KD_EMPTY)
        p = cell_parent_of(parent, bit >> 3, params.tree.y);
    return cell_load(p, bit & 7u);
}
