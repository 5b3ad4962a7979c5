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
//   leaf          uvec2: S as rgb9e5 | normal 3 x snorm8, tau 7 bits of 0 … FULL_DEPTH, thin 1 bit: 0
//                 or, where the two sides of something thin are in it, or it is double-sided: S of the brighter side | axis octahedral
//                 2 x 8 bits, 1 bit: the brighter side is where the axis points away from, cube root of the other side's share
//                 of S 7 bits, tau, thin: 1
//   sparse node   uvec2: S as rgb9e5 | tau for rays towards +x -x +y -y +z -z, 5 bits each of 0 … FULL_DEPTH
//   dense cell    six RGBA16F texels: (tau S, tau) for rays towards +x -x +y -y +z -z

#include "shaders/shared/voxel.h"
#include "shaders/include/half_pack.glsl"
#include "shaders/include/octahedral.glsl"

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
    float side[6];  // share of S that rays of the direction see
};

struct leaf_value {
    vec3 radiance;
    vec3 normal; // shorter than 1 where surfaces of several directions meet; of what is thin a unit axis
    float depth;
    bool thin;   // met from both sides: `radiance` is what the side sends out that the axis points to,
    float other; // and this share of it the other side
};

// The brighter side of what is thin is the one that the axis points to, or away from when it is `turned`.
uvec2 leaf_pack(leaf_value v, bool turned)
{
    uint depth = uint(round(clamp(v.depth / FULL_DEPTH, 0.0, 1.0) * 127.0)), normal;
    if (v.thin)
        normal = octahedral_pack(v.normal) | uint(turned) << 16 | uint(round(pow(clamp(v.other, 0.0, 1.0), 1.0 / 3.0) * 127.0)) << 17;
    else
        normal = packSnorm4x8(vec4(v.normal, 0.0)) & 0xFFFFFFu;
    return uvec2(rgb9e5_pack(min(v.radiance, vec3(65000.0 / FULL_DEPTH))), normal | depth << 24 | uint(v.thin) << 31);
}

leaf_value leaf_unpack(uvec2 w)
{
    bool thin = (w.y >> 31) != 0u;
    float root = thin ? float(w.y >> 17 & 127u) * (1.0 / 127.0) : 1.0, points = (w.y >> 16 & 1u) != 0u ? -1.0 : 1.0;
    vec3 normal = thin ? points * octahedral_unpack(w.y) : unpackSnorm4x8(w.y).xyz;
    return leaf_value(rgb9e5_unpack(w.x), normal, float((w.y >> 24) & 127u) * (FULL_DEPTH / 127.0), thin, root * root * root);
}

// Share of a leaf's matter that a ray along `direction` meets from its front: none when it runs along the surface or leaves
// it, all from 30 degrees of incidence on. Where normals cancel (edges, sheets thinner than a voxel) all of it counts.
float leaf_facing(leaf_value v, vec3 direction)
{
    float towards = -dot(v.normal, direction);
    if (v.thin)
        towards = abs(towards);
    return smoothstep(0.0, 0.5, towards + 0.8 * max(0.9 - length(v.normal), 0.0));
}

// Share of its radiance that a ray along `direction` sees.
float leaf_side(leaf_value v, vec3 direction) { return dot(v.normal, direction) > 0.0 ? v.other : 1.0; }

// (tau S, tau) as a ray along `direction` sees it.
vec4 leaf_seen(leaf_value v, vec3 direction)
{
    float depth = v.depth * leaf_facing(v, direction);
    return vec4(v.radiance * (depth * leaf_side(v, direction)), depth);
}

const vec3 NODE_DIRECTIONS[6] = vec3[6](vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1));

node_value node_of_leaf(uvec2 word)
{
    leaf_value v = leaf_unpack(word);
    node_value n;
    n.radiance = v.radiance;
    for (int i = 0; i < 6; i++) {
        n.depth[i] = v.depth > 0.0 ? v.depth * leaf_facing(v, NODE_DIRECTIONS[i]) : 0.0;
        n.side[i] = leaf_side(v, NODE_DIRECTIONS[i]);
    }
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
    for (int i = 0; i < 6; i++) {
        n.depth[i] = float((w.y >> (5 * i)) & 31u) * (FULL_DEPTH / 31.0);
        n.side[i] = 1.0;
    }
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
