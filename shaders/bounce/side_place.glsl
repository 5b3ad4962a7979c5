// Where the surfaces lie that take their light from a side of a dense cell, and which way they face.

#include "shaders/include/tree.glsl"

struct side_place {
    vec3 p_ws, normal;
};

// How much of the side's light a leaf takes (inject.comp), and the normal that it shows to it.
float side_share(leaf_value v, vec3 axis, out vec3 normal)
{
    float gathered = length(v.normal), directed = min(2.0 * gathered, 1.0);
    vec3 unit = v.normal / max(gathered, 1e-3);
    float towards = dot(unit, axis), seen = v.thin ? abs(towards) : max(towards, 0.0);
    normal = mix(axis, towards < 0.0 ? -unit : unit, directed);
    return v.depth * mix(1.0 / 6.0, seen * seen, directed);
}

// Means over the leaves of a cell, counted from its cascade's low corner; its middle and the axis when none takes light.
// A turned wall is lit by its own normal then, whatever sides it takes light from.
side_place side_place_of(int c, ivec3 cell, vec3 axis)
{
    const int PARENTS = 1 << (KD_SPARSE_LEVELS - 1); // of leaves, along an edge
    vec3 normal = vec3(0.0), place = vec3(0.0), leaf_normal;
    ivec3 low = cell << KD_SPARSE_LEVELS, wrapped = tree_wrap(c, 1, low >> 1);
    float span = tree_finest_edge(c) / tree.cascade[c].w, all = 0.0;
    for (int i = 0; i < PARENTS * PARENTS * PARENTS; i++) {
        ivec3 parent = ivec3(i, i >> (KD_SPARSE_LEVELS - 1), i >> 2 * (KD_SPARSE_LEVELS - 1)) & (PARENTS - 1);
        uint block = tree_leaf_block(c, wrapped + parent);
        for (uint k = 0u; k < 8u && block != 0u; k++) {
            if (!KD_BLOCK_WIDE && !block_has(block, k))
                continue;
            float share = side_share(leaf_unpack(texelFetch(tree_leaves, int(block_slot(block, k))).rg), axis, leaf_normal);
            normal += share * leaf_normal;
            place += share * (vec3(low + 2 * parent + (ivec3(k, k >> 1, k >> 2) & 1)) + 0.5 * span);
            all += share;
        }
    }
    if (all <= 0.0)
        return side_place(tree.cascade[c].xyz + (vec3(low) + 0.5 * float(2 * PARENTS)) * tree.cascade[c].w, axis);
    return side_place(tree.cascade[c].xyz + place * (tree.cascade[c].w / all), normalize(normal));
}
