// The tree by cells, without interpolation: the value of the cell round a place at any level. Levels: `lod` of
// shaders/include/tree.glsl; k: the finest cascade that covers the place, lod >= k.

#include "shaders/include/tree.glsl"

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

// One direction of a dense cell, or of one above the outermost cascade; layout: KD_ATLAS_BLOCK in shaders/shared/voxel.h.
vec4 dense_fetch(cell_place at, int direction)
{
    int mip = at.level - KD_SPARSE_LEVELS, apart = mip == 0 ? KD_ATLAS_BLOCK : KD_DENSE / 2;
    int before = (mip == 0 ? at.cascade : tree_cascades()) * KD_ATLAS_BLOCK, border = int(mip == 0);
    ivec3 cell = mip == 0 ? tree_wrap(at.cascade, at.level, at.cell) : at.cell + ivec3(0, KD_DENSE - (2 * KD_DENSE >> mip), 0);
    vec3 depths = texelFetch(tree_depths, cell + ivec3(0, 0, before * 2 + border + (direction & 1) * apart), 0).rgb;
    return vec4(texelFetch(tree_atlas, cell + ivec3(0, 0, before * 6 + border + direction * apart), 0).rgb,
                depths[direction >> 1]);
}

// (tau S, tau) along its own edge, as a ray along `direction` sees it.
vec4 cell_seen(cell_place at, vec3 direction)
{
    if (at.level < KD_SPARSE_LEVELS)
        return tree_fetch_sparse(at.cascade, at.level, at.cell, direction);
    vec3 weight = abs(direction);
    return weight.x * dense_fetch(at, direction.x < 0.0 ? 1 : 0) + weight.y * dense_fetch(at, direction.y < 0.0 ? 3 : 2) +
           weight.z * dense_fetch(at, direction.z < 0.0 ? 5 : 4);
}
