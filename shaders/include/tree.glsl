#ifndef KD_INCLUDE_TREE_GLSL
#define KD_INCLUDE_TREE_GLSL

// Sampling the octree. Values are (tau S, tau), see tree_node.glsl; lod 0 is the finest cascade's voxel edge, each step
// doubles it. Programs are compiled for a number of sparse levels: KD_SPARSE_LEVELS (1: leaves right below the dense cells).
//
// Which cells hold a size at a place: the finest cascade k that covers the place has leaves at lod k, sparse nodes above
// them and dense cells from lod k + KD_SPARSE_LEVELS on; beyond that every coarser cascade's dense cells follow, which hold
// the finer cascades' averages in their central half, and above the outermost its mips.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/tree_node.glsl"
#ifndef KD_BLOCK_WIDE
#define KD_BLOCK_WIDE (KD_SPARSE_LEVELS == 1)
#endif
#include "shaders/include/leaf_block.glsl"

layout(binding = KD_UNIT_TREE_RADIANCE) uniform sampler3D tree_atlas;
layout(binding = KD_UNIT_TREE_DEPTH) uniform sampler3D tree_depths;
layout(binding = KD_UNIT_TREE_INDEX) uniform usamplerBuffer tree_index;
layout(binding = KD_UNIT_TREE_NODES) uniform usamplerBuffer tree_nodes;
layout(binding = KD_UNIT_TREE_LEAVES) uniform usamplerBuffer tree_leaves;
layout(binding = KD_UNIT_TREE_DATA) uniform usamplerBuffer tree_data;

int tree_cascades() { return int(tree.info.x); }
int tree_resolution() { return int(tree.info.y); }

// The finest lod of cascade k: where there was not room for all levels its leaves are not sampled.
int tree_finest(int k) { return k + int(cascade_given_up(uint(k))); }

// Edge of its finest cells.
float tree_finest_edge(int k) { return tree.cascade[0].w * float(1 << tree_finest(k)); }

// Finest cascade (they are concentric) that covers p with `margin` of its dense cells to spare; tree_cascades() when none does.
int tree_cascade_at(vec3 p_ws, float margin)
{
    vec3 from_centre = abs(p_ws - tree.centre.xyz) * tree.centre.w;
    float reach = max(from_centre.x, max(from_centre.y, from_centre.z)), limit = 1.0 - margin * (2.0 / float(KD_DENSE));
    int c = int(reach >= limit) + int(reach >= 2.0 * limit) + int(reach >= 4.0 * limit) + int(reach >= 8.0 * limit);
    return min(c, tree_cascades());
}

// Cells are given from the cascade's low corner, and kept under their wrapped places (tree_params.glsl).
ivec3 tree_wrap(int c, int level, ivec3 cell)
{
    return (cell + (tree.origin[c].xyz >> level)) & ((tree_resolution() >> level) - 1);
}

int tree_dense_place(int c, ivec3 cell)
{
    return ((c * KD_DENSE + cell.z) * KD_DENSE + cell.y) * KD_DENSE + cell.x;
}

// Node of a (wrapped) dense cell, KD_EMPTY when there is nothing in it.
uint tree_dense_node(int c, ivec3 cell)
{
    return texelFetch(tree_index, tree_dense_place(c, cell)).r;
}

int tree_octant(ivec3 cell, int shift)
{
    ivec3 o = (cell >> shift) & 1;
    return o.x | o.y << 1 | o.z << 2;
}

// Down to the parent of a (wrapped) cell of a sparse level: its node, or KD_EMPTY. `level` 0 are leaves.
uint tree_parent(int c, int level, ivec3 cell)
{
    int shift = KD_SPARSE_LEVELS - level;
    uint node = tree_dense_node(c, cell >> shift);
    for (int l = 0; l < KD_SPARSE_LEVELS - 1; l++) {
        shift--;
        if (node == KD_EMPTY || shift == 0)
            break;
        node = texelFetch(tree_nodes, int(tree.node_offset[l] + node * 8u) + tree_octant(cell, shift)).r;
    }
    return node;
}

// Block of the leaves in a (wrapped) cell twice as large.
uint tree_leaf_block(int c, ivec3 cell)
{
    int first = int(tree.node_offset[KD_SPARSE_LEVELS - 1]);
#if KD_SPARSE_LEVELS == 1
    return texelFetch(tree_nodes, first + tree_dense_place(c, cell)).r;
#else
    uint above = tree_parent(c, 1, cell);
    return above == KD_EMPTY ? 0u : texelFetch(tree_nodes, first + int(above) * 8 + tree_octant(cell, 0)).r;
#endif
}

uvec2 tree_fetch_leaf(int c, ivec3 cell)
{
    cell = tree_wrap(c, 0, cell);
    uint block = tree_leaf_block(c, cell >> 1), k = uint(tree_octant(cell, 0));
    bool there = KD_BLOCK_WIDE ? block != 0u : block_has(block, k);
    return there ? texelFetch(tree_leaves, int(block_slot(block, k))).rg : uvec2(0u);
}

// Node of a (wrapped) cell of sparse level 1 … KD_SPARSE_LEVELS - 1, or KD_EMPTY.
uint tree_node(int c, int level, ivec3 cell)
{
    uint parent = tree_parent(c, level, cell);
    if (parent == KD_EMPTY)
        return KD_EMPTY;
    return texelFetch(tree_nodes, int(tree.node_offset[KD_SPARSE_LEVELS - level - 1] + parent * 8u) + tree_octant(cell, 0)).r;
}

// A node of sparse level 1 … KD_SPARSE_LEVELS - 1, as a ray along `direction` sees it.
vec4 tree_fetch_node(int c, int level, ivec3 cell, vec3 direction)
{
#if KD_SPARSE_LEVELS > 1
    uint node = tree_node(c, level, tree_wrap(c, level, cell));
    if (node == KD_EMPTY)
        return vec4(0.0);
    return node_seen(texelFetch(tree_data, int(tree.data_offset[KD_SPARSE_LEVELS - level - 1] + node)).rg, direction, abs(direction));
#else
    return vec4(0.0);
#endif
}

vec4 tree_fetch_sparse(int c, int level, ivec3 cell, vec3 direction)
{
    return level == 0 ? leaf_seen(leaf_unpack(tree_fetch_leaf(c, cell)), direction) : tree_fetch_node(c, level, cell, direction);
}

// Trilinear by hand over the eight cells round p (Yalciner 2016, section 4.6). Leaves: what is interpolated is their matter,
// that of thin ones as the side has it which the ray meets, and whether it meets a front is asked once, of the mean normal;
// strictly, of each leaf, since the mean of a wall's two sides has the light of both.
#ifdef KD_LEAK_STRICT
vec4 tree_sample_leaves(int c, vec3 p_ws, vec3 direction)
{
    vec3 p = (p_ws - tree.cascade[c].xyz) / tree.cascade[c].w - 0.5;
    ivec3 low = ivec3(floor(p)), top = ivec3(tree_resolution() - 1);
    vec3 f = p - vec3(low);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 8; i++) {
        ivec3 o = ivec3(i, i >> 1, i >> 2) & 1;
        vec3 w = mix(1.0 - f, f, vec3(o));
        sum += (w.x * w.y * w.z) * leaf_seen(leaf_unpack(tree_fetch_leaf(c, clamp(low + o, ivec3(0), top))), direction);
    }
    return sum;
}
#else
vec4 tree_sample_leaves(int c, vec3 p_ws, vec3 direction)
{
    vec3 p = (p_ws - tree.cascade[c].xyz) / tree.cascade[c].w - 0.5;
    ivec3 low = ivec3(floor(p)), top = ivec3(tree_resolution() - 1);
    vec3 f = p - vec3(low), light = vec3(0.0), normal = vec3(0.0);
    float depth = 0.0;
    for (int i = 0; i < 8; i++) {
        ivec3 o = ivec3(i, i >> 1, i >> 2) & 1;
        vec3 w = mix(1.0 - f, f, vec3(o));
        uvec2 word = tree_fetch_leaf(c, clamp(low + o, ivec3(0), top));
        leaf_value v = leaf_unpack(word);
        float d = w.x * w.y * w.z * v.depth;
        bool leaves = dot(v.normal, direction) > 0.0;
        light += (leaves ? d * v.other : d) * v.radiance;
        normal += v.thin && leaves ? -d * v.normal : d * v.normal;
        depth += d;
    }
    if (depth <= 0.0)
        return vec4(0.0);
    return leaf_seen(leaf_value(light / depth, normal / depth, depth, false, 1.0), direction);
}
#endif

vec4 tree_sample_nodes(int c, int level, vec3 p_ws, vec3 direction)
{
    vec3 p = (p_ws - tree.cascade[c].xyz) / (tree.cascade[c].w * float(1 << level)) - 0.5;
    ivec3 low = ivec3(floor(p));
    vec3 f = p - vec3(low);
    int top = (tree_resolution() >> level) - 1;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 8; i++) {
        ivec3 o = ivec3(i, i >> 1, i >> 2) & 1;
        vec3 w = mix(1.0 - f, f, vec3(o));
        sum += (w.x * w.y * w.z) * tree_fetch_node(c, level, clamp(low + o, ivec3(0), ivec3(top)), direction);
    }
    return sum;
}

// Where the atlas holds dense cells of cascade c (mip 0), or of level `mip` above the outermost, in texels: coordinates are
// kept half a cell inside the cascade, then wrapped, along x and y by the sampler, along z by the slices that stand before and
// behind each block. Parts lie `apart` slices behind each other, from `radiance` and `depth` on.
struct tree_texel {
    vec3 at;
    float apart, radiance, depth;
};

tree_texel tree_texel_of(int c, int mip, vec3 cell)
{
    float size = float(KD_DENSE >> mip);
    tree_texel t;
    t.at = clamp(cell, vec3(0.5), vec3(size - 0.5));
    if (mip == 0) {
        t.at += vec3((tree.origin[c].xyz >> KD_SPARSE_LEVELS) & (KD_DENSE - 1));
        t.at.z -= t.at.z >= float(KD_DENSE) ? float(KD_DENSE) : 0.0;
        t.apart = float(KD_ATLAS_BLOCK);
        t.radiance = float(c * 6 * KD_ATLAS_BLOCK + 1);
        t.depth = float(c * 2 * KD_ATLAS_BLOCK + 1);
    } else {
        t.at.y += float(KD_DENSE - (2 * KD_DENSE >> mip));
        t.apart = float(KD_DENSE / 2);
        t.radiance = float(tree_cascades() * 6 * KD_ATLAS_BLOCK);
        t.depth = float(tree_cascades() * 2 * KD_ATLAS_BLOCK);
    }
    return t;
}

vec3 tree_texel_depths(tree_texel t, float part)
{
    return textureLod(tree_depths, vec3(t.at.xy, t.at.z + t.depth + part * t.apart) * tree.atlas.xyw, 0.0).rgb;
}

vec3 tree_texel_radiance(tree_texel t, float part)
{
    return textureLod(tree_atlas, vec3(t.at.xy, t.at.z + t.radiance + part * t.apart) * tree.atlas.xyz, 0.0).rgb;
}

// A ray that comes aslant may meet a wall's outer side by one of its axes and its inner side by another: the darkest of the axes
// that matter is what it sees then. light: what the axes show, depths: theirs, weight: that of the axes.
vec3 tree_darkest(mat3 light, vec3 depths, vec3 weight, float all)
{
#ifdef KD_LEAK_STRICT
    const float LEAST_SHARE = 0.005;
#else
    const float LEAST_SHARE = 0.02;
#endif
    bvec3 counts = greaterThan(weight * depths, vec3(LEAST_SHARE * all));
    vec3 whole = all / max(depths, vec3(1e-9)), far = vec3(all > 0.0 ? 1e30 : 0.0);
    return min(min(counts.x ? light[0] * whole.x : far, counts.y ? light[1] * whole.y : far), counts.z ? light[2] * whole.z : far);
}

// How far a cell is of something thin, which its axes meet both ways. In wide cells everything is: halls would be too dark by it.
const int THIN_LEVELS = 2; // above the finest dense cells

float tree_thinness(vec3 forth, vec3 back, vec3 weight, int level)
{
    float both = dot(weight, min(forth, back)), all = dot(weight, max(forth, back));
    return level > THIN_LEVELS ? 0.0 : smoothstep(0.3 * all, 0.7 * all + 1e-6, both);
}

tree_texel tree_texel_at(int c, int mip, vec3 p_ws)
{
    float edge = tree.cascade[c].w * float(1 << (KD_SPARSE_LEVELS + mip));
    return tree_texel_of(c, mip, (p_ws - tree.cascade[c].xyz) / edge);
}

vec4 tree_sample_dense(int c, int mip, vec3 p_ws, vec3 direction)
{
    tree_texel t = tree_texel_at(c, mip, p_ws);
    vec3 weight = abs(direction), back = vec3(lessThan(direction, vec3(0.0)));
    vec3 forth = tree_texel_depths(t, 0.0), against = tree_texel_depths(t, 1.0), depths = mix(forth, against, back);
    mat3 axes = mat3(tree_texel_radiance(t, back.x), tree_texel_radiance(t, 2.0 + back.y), tree_texel_radiance(t, 4.0 + back.z));
    float all = dot(weight, depths);
#ifdef KD_LEAK_STRICT
    return vec4(tree_darkest(axes, depths, weight, all), all);
#endif
    vec3 light = axes * weight;
    light = mix(light, min(light, tree_darkest(axes, depths, weight, all)), tree_thinness(forth, against, weight, c + mip));
    // Stored depths share an exponent: of so little of them light is not known.
    const float LEAST_DEPTH = 0.04 * FULL_DEPTH;
    return smoothstep(0.0, LEAST_DEPTH, all) * vec4(light, all);
}

// Is a value of this lod, in a place whose finest cascade is k (lod >= k), one of leaves or sparse nodes?
bool tree_is_sparse(int k, int lod) { return lod < k + KD_SPARSE_LEVELS; }

// Value at integral lod, per metre of the ray's path; of leaves and sparse nodes.
vec4 tree_sample_sparse(int k, int lod, vec3 p_ws, vec3 direction)
{
#if KD_SPARSE_LEVELS > 1
    vec4 v = lod == k ? tree_sample_leaves(k, p_ws, direction) : tree_sample_nodes(k, lod - k, p_ws, direction);
#else
    vec4 v = tree_sample_leaves(k, p_ws, direction);
#endif
    return v / (tree.cascade[0].w * exp2(float(lod)));
}

// Cascade and mip of dense cells, and of what lies above them.
ivec2 tree_dense_of(int lod)
{
    int c = min(lod - KD_SPARSE_LEVELS, tree_cascades() - 1);
    return ivec2(c, max(lod - KD_SPARSE_LEVELS - c, 0));
}

int tree_last_lod() { return tree_cascades() - 1 + KD_SPARSE_LEVELS + KD_DENSE_MIPS; }

// The same of these.
vec4 tree_sample_wide(int k, int lod, vec3 p_ws, vec3 direction)
{
    lod = min(lod, tree_last_lod());
    ivec2 dense = tree_dense_of(lod);
    vec4 v = tree_sample_dense(dense.x, dense.y, p_ws, direction);
    return v / (tree.cascade[0].w * exp2(float(lod)));
}

#endif
