// The tree by cells, without interpolation: the value of the cell round a place at any level, and what the channels of the
// views show of it. Levels: `lod` of shaders/include/tree.glsl; k: the finest cascade that covers the place, lod >= k.

#include "shaders/shared/debug_view.h"
#include "shaders/include/tree.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/cell_load.glsl"
#include "shaders/debug_view/show.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_debug_view_params params; };

struct cell_place {
    int cascade; // whose cells hold this size here
    int level;   // above its leaves; KD_SPARSE_LEVELS: its dense cells, and on: those above the outermost cascade
    float edge;  // m
    ivec3 cell;  // from the cascade's low corner
};

int lod_most() { return tree_cascades() - 1 + KD_SPARSE_LEVELS + KD_DENSE_MIPS; }

cell_place cell_at(int k, int lod, vec3 p_ws)
{
    cell_place at;
    at.cascade = lod < k + KD_SPARSE_LEVELS ? k : min(lod - KD_SPARSE_LEVELS, tree_cascades() - 1);
    at.level = lod - at.cascade;
    at.edge = tree.cascade[0].w * exp2(float(lod));
    int last = (tree_resolution() >> at.level) - 1;
    at.cell = clamp(ivec3(floor((p_ws - tree.cascade[at.cascade].xyz) / at.edge)), ivec3(0), ivec3(last));
    return at;
}

vec3 cell_low(cell_place at) { return tree.cascade[at.cascade].xyz + vec3(at.cell) * at.edge; }

// (tau S, tau) along its own edge, as a ray along `direction` sees it.
vec4 cell_seen(cell_place at, vec3 direction)
{
    if (at.level < KD_SPARSE_LEVELS)
        return tree_fetch_sparse(at.cascade, at.level, at.cell, direction);
    return tree_sample_dense(at.cascade, at.level - KD_SPARSE_LEVELS, cell_low(at) + 0.5 * at.edge, direction);
}

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
    uint slot = (parent == KD_EMPTY ? 0u : parent * 8u) + uint(tree_octant(cell, 0));
    return cell_load(slot, bit, params.tree.x, params.tree.y);
}
