// Radiance and optical depth of tree nodes.
//
// A node is a small piece of participating medium: optical depth tau per edge length of the node, and the radiance S that its
// matter sends out. Optical depths add up along a ray however the wall lies between two cells, which opacities do not; so
// everything that is interpolated is (tau S, tau), and a wall has its whole depth at every offset.
//
// A ray ends when it has gone through the depth of a covered cell. What is left of it is exp(-tau) less the share that it would
// have then: nothing gets through a wall, and the parts of one add up to it.
//
// Depth has six directions: matter stops a ray that meets its front side. A ray that leaves a surface does not see the cells
// of that surface, however coarse they are; without this a wide cone shadows itself at every level.
//
//   leaf          uvec2: S as rgb9e5 | normal 3 x snorm8, tau 7 bits of 0 … FULL_DEPTH, double sided 1 bit
//   sparse node   uvec2: S as rgb9e5 | tau for rays towards +x -x +y -y +z -z, 5 bits each of 0 … FULL_DEPTH
//   dense cell    six RGBA16F texels: (tau S, tau) for rays towards +x -x +y -y +z -z

#include "shaders/shared/voxel.h"
#include "shaders/include/half_pack.glsl"

const float FULL_DEPTH = KD_FULL_DEPTH;

// exp(-depth) / (1 - exp(-depth)): what would still be open after the depth at which nothing is.
float depth_residue(float depth) { return 1.0 / (exp(depth) - 1.0); }

// Open share of a ray after matter of optical depth `depth`, from the share before.
float open_after(float open, float depth, float residue)
{
    float through = exp(-depth);
    return max(open * through - residue * (1.0 - through), 0.0);
}

struct node_value {
    vec3 radiance;  // S
    float depth[6]; // tau by direction
};

struct leaf_value {
    vec3 radiance;
    vec3 normal;    // shorter than 1 where surfaces of several directions meet
    float depth;
    bool double_sided;
};

uvec2 leaf_pack(leaf_value v)
{
    uint normal = packSnorm4x8(vec4(v.normal, 0.0)) & 0xFFFFFFu;
    uint depth = uint(round(clamp(v.depth / FULL_DEPTH, 0.0, 1.0) * 127.0));
    return uvec2(rgb9e5_pack(min(v.radiance, vec3(65000.0 / FULL_DEPTH))), normal | depth << 24 | uint(v.double_sided) << 31);
}

leaf_value leaf_unpack(uvec2 w)
{
    return leaf_value(rgb9e5_unpack(w.x), unpackSnorm4x8(w.y).xyz, float((w.y >> 24) & 127u) * (FULL_DEPTH / 127.0), (w.y >> 31) != 0u);
}

// Share of a leaf's matter that a ray along `direction` meets from its front: none when it runs along the surface or leaves
// it, all from 30 degrees of incidence on. Where normals cancel (edges, sheets thinner than a voxel) all of it counts.
float leaf_facing(leaf_value v, vec3 direction)
{
    float towards = -dot(v.normal, direction);
    if (v.double_sided)
        towards = abs(towards);
    return smoothstep(0.0, 0.5, towards + 0.8 * max(0.9 - length(v.normal), 0.0));
}

// (tau S, tau) as a ray along `direction` sees it.
vec4 leaf_seen(leaf_value v, vec3 direction)
{
    float depth = v.depth * leaf_facing(v, direction);
    return vec4(v.radiance * depth, depth);
}

const vec3 NODE_DIRECTIONS[6] = vec3[6](vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1));

node_value node_of_leaf(uvec2 word)
{
    leaf_value v = leaf_unpack(word);
    node_value n;
    n.radiance = v.radiance;
    for (int i = 0; i < 6; i++)
        n.depth[i] = v.depth > 0.0 ? v.depth * leaf_facing(v, NODE_DIRECTIONS[i]) : 0.0;
    return n;
}

uvec2 node_pack(node_value n)
{
    uint depths = 0u;
    for (int i = 0; i < 6; i++)
        depths |= uint(round(clamp(n.depth[i] / FULL_DEPTH, 0.0, 1.0) * 31.0)) << (5 * i);
    return uvec2(rgb9e5_pack(n.radiance), depths);
}

node_value node_unpack(uvec2 w)
{
    node_value n;
    n.radiance = rgb9e5_unpack(w.x);
    for (int i = 0; i < 6; i++)
        n.depth[i] = float((w.y >> (5 * i)) & 31u) * (FULL_DEPTH / 31.0);
    return n;
}

// The same, when only the depth along one ray is wanted: its three directions weighted by `weight` = abs(direction).
vec4 node_seen(uvec2 w, vec3 direction, vec3 weight)
{
    uvec3 shift = mix(uvec3(0u, 10u, 20u), uvec3(5u, 15u, 25u), lessThan(direction, vec3(0.0)));
    float depth = dot(vec3((uvec3(w.y) >> shift) & 31u), weight) * (FULL_DEPTH / 31.0);
    return vec4(rgb9e5_unpack(w.x) * depth, depth);
}

// Share of rays that matter of a depth stops.
float depth_opacity(float depth) { return 1.0 - open_after(1.0, depth, depth_residue(FULL_DEPTH)); }

// What two cells in a row show to a ray that meets `front` first: light (xyz) and opacity (w).
vec4 behind(vec3 front_radiance, float front_depth, vec3 back_radiance, float back_depth)
{
    float residue = depth_residue(FULL_DEPTH), between = open_after(1.0, front_depth, residue), after = open_after(between, back_depth, residue);
    return vec4((1.0 - between) * front_radiance + (between - after) * back_radiance, 1.0 - after);
}

// Mean over columns back to (tau S, tau) of the parent's own edge length. `depths`: of the columns together. Strictly it is their
// mean that counts and not that of opacities, so that a wall which lies aslant in coarse cells keeps its whole depth.
vec4 column_mean(vec4 sum, float depths, bool strict)
{
    vec4 mean = 0.25 * sum;
    float depth = -log(1.0 - mean.a * (1.0 - exp(-FULL_DEPTH)));
    depth = strict ? 0.25 * depths : depth;
    return mean.a > 0.0 ? vec4(mean.rgb * (depth / mean.a), depth) : vec4(0.0);
}

// Share of its light that a node may show under `light.leak=strict`, by its depths along +x +y +z and back: none when it is met
// from two opposite sides, since what lights one side of a thin wall would be seen from the other.
float light_of_one_side(vec3 forth, vec3 back)
{
    vec3 share = clamp(1.0 - 6.0 * min(forth, back) / max(max(forth, back), vec3(1e-6)), 0.0, 1.0);
    return share.x * share.y * share.z;
}
