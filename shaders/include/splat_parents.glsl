// Leaf parents of the corners of a splat's block. Their codes are put together of near and far parts of the three axes, which
// are made once a voxel: software drivers read uniforms lane by lane where the cascade differs.

#include "shaders/include/splat.glsl"
#include "shaders/include/morton.glsl"

struct splat_codes {
    uvec3 near, far;
    uint first; // of the cascade
    uint stands; // bits that the parent of a cell that stands for others keeps
};

splat_codes splat_parent_codes(splat s, uint c)
{
    uvec3 near = cell_wrap(c, s.cell) >> 1u, far = cell_wrap(c, s.cell + 1) >> 1u;
    return splat_codes(uvec3(morton_spread(near.x), morton_spread(near.y) << 1, morton_spread(near.z) << 2),
                       uvec3(morton_spread(far.x), morton_spread(far.y) << 1, morton_spread(far.z) << 2), cascade_first_bit(c) >> 3u,
                       cell_standing(c, 0xFFFFFFFFu) >> 3u);
}

// Of corner k: its bit in the mask of leaf parents.
uint splat_parent_code(splat_codes codes, uint k)
{
    uvec3 code = mix(codes.near, codes.far, notEqual(uvec3(k, k >> 1, k >> 2) & 1u, uvec3(0u)));
    return codes.first | ((code.x | code.y | code.z) & codes.stands);
}
