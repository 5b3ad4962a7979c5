// Radiance and optical depth of tree nodes.
//
// A node is a small piece of participating medium: optical depth tau along each axis, per edge length of the node, and the
// radiance S that its matter sends out. Optical depths add up along a ray however the wall lies between two cells, which
// opacities do not; so everything that is interpolated is (tau * S, tau), and a wall lets exp(-6) through at every offset.
//
//   leaf          uvec2: half4 (tau S, tau), the same for all axes
//   sparse node   uvec2: S as rgb9e5 | tau x, y, z as 10 bits each of 0 … 6
//   dense cell    six RGBA16F texels: (tau S, tau) for rays that travel towards +x -x +y -y +z -z

#include "shaders/shared/voxel.h"
#include "shaders/include/half_pack.glsl"

const float FULL_DEPTH = KD_FULL_DEPTH;

struct node_value {
    vec3 radiance; // S
    vec3 depth;    // tau by axis
};

uvec2 leaf_pack(vec3 radiance, float depth)
{
    vec3 j = min(radiance * depth, vec3(65000.0));
    return uvec2(packHalf2x16(j.rg), packHalf2x16(vec2(j.b, depth)));
}

// (tau S, tau)
vec4 leaf_unpack(uvec2 w)
{
    return vec4(unpackHalf2x16(w.x), unpackHalf2x16(w.y));
}

node_value leaf_value(uvec2 w)
{
    vec4 v = leaf_unpack(w);
    return node_value(v.a > 0.0 ? v.rgb / v.a : vec3(0.0), vec3(v.a));
}

uvec2 node_pack(node_value n)
{
    uvec3 d = uvec3(round(clamp(n.depth / FULL_DEPTH, 0.0, 1.0) * 1023.0));
    return uvec2(rgb9e5_pack(n.radiance), d.x | d.y << 10 | d.z << 20);
}

node_value node_unpack(uvec2 w)
{
    return node_value(rgb9e5_unpack(w.x), vec3(w.y & 1023u, (w.y >> 10) & 1023u, (w.y >> 20) & 1023u) * (FULL_DEPTH / 1023.0));
}

// What two cells in a row show to a ray that meets `front` first: light (xyz) and opacity (w).
vec4 behind(vec3 front_radiance, float front_depth, vec3 back_radiance, float back_depth)
{
    float front = exp(-front_depth), back = exp(-back_depth);
    return vec4((1.0 - front) * front_radiance + front * (1.0 - back) * back_radiance, 1.0 - front * back);
}

// Mean over columns back to (tau S, tau) of the parent's own edge length.
vec4 column_mean(vec4 sum)
{
    vec4 mean = 0.25 * sum;
    float depth = min(-log(max(1.0 - mean.a, exp(-FULL_DEPTH))), FULL_DEPTH);
    return mean.a > 0.0 ? vec4(mean.rgb * (depth / mean.a), depth) : vec4(0.0);
}
