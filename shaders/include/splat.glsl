// Coverage of a transformed voxel: a box as large as a cell, shared out over the 2x2x2 cells that it touches by trilinear
// weights. The weights of a voxel add up to 256, less the shares too small to mark (4 % in the mean), so a surface keeps its
// optical depth while it moves through the grid, and changes without steps. A voxel that falls on a cell covers that cell alone.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/voxel_pack.glsl"

struct splat {
    ivec3 cell;     // low cell of the block, may be -1
    uvec3 fraction; // share of the far cells, of 256
};

// position: of the voxel's centre in cells of cascade c, from the world's origin: so that it falls on the same cells wherever
// the cascade stands
splat splat_at(uint c, vec3 position)
{
    splat s;
    precise vec3 corner = position - 0.5, low = floor(corner);
    precise vec3 share = (corner - low) * 256.0 + 0.5;
    s.cell = ivec3(low) - tree.origin[c].xyz;
    s.fraction = uvec3(share);
    for (int k = 0; k < 3; k++) {
        if (s.fraction[k] > 248u) {
            s.cell[k]++;
            s.fraction[k] = 0u;
        } else if (s.fraction[k] < 8u) {
            s.fraction[k] = 0u;
        }
    }
    return s;
}

// Can a voxel there cover cells of cascade c at all?
bool splat_inside(uint c, vec3 position)
{
    vec3 from_corner = position - vec3(tree.origin[c].xyz);
    return all(greaterThanEqual(from_corner, vec3(-0.5))) && all(lessThanEqual(from_corner, vec3(float(tree.info.y) + 0.5)));
}

// Share of corner i (bit 0 x, bit 1 y, bit 2 z) of the block, of 256.
uint splat_weight(splat s, uint i)
{
    uvec3 w = mix(256u - s.fraction, s.fraction, notEqual(uvec3(i, i >> 1, i >> 2) & 1u, uvec3(0u)));
    return (w.x * w.y * w.z) >> 16;
}

ivec3 splat_cell(splat s, uint i)
{
    return s.cell + ivec3(uvec3(i, i >> 1, i >> 2) & 1u);
}

// Corners of a block on whose near and far cells the three axes say yes, one bit each.
uint splat_corners_where(bvec3 near, bvec3 far)
{
    uvec3 sides = mix(uvec3(0u), uvec3(0x55u, 0x33u, 0x0Fu), near) | mix(uvec3(0u), uvec3(0xAAu, 0xCCu, 0xF0u), far);
    return sides.x & sides.y & sides.z;
}

// Corners of the block at `cell` that cascade c owns: inside it, and not in the central half, which the finer one covers.
uint splat_owned(uint c, ivec3 cell)
{
    uvec3 near = uvec3(cell), far = uvec3(cell + 1), edge = uvec3(tree.info.y), quarter = edge >> 2u;
    uint inside = splat_corners_where(lessThan(near, edge), lessThan(far, edge));
    uint finer = splat_corners_where(lessThan(near - quarter, 2u * quarter), lessThan(far - quarter, 2u * quarter));
    return c > 0u ? inside & ~finer : inside;
}

// Corners that leave a mark in cascade c, one bit each. Loops go over these bits alone: most voxels that stand still cover one
// cell, and software drivers run a loop's body for what is masked off too.
uint splat_corners(splat s, uint c)
{
    uint marked = 0u;
    for (uint i = 0u; i < 8u; i++)
        marked |= uint(splat_weight(s, i) >= KD_SPLAT_MIN_WEIGHT) << i;
    return marked & splat_owned(c, s.cell);
}

// Corners that stand for the leaf parents which the marked ones lie in, one each: near and far cells on an axis share theirs
// when the near one is even (cascades begin at even cells).
uint splat_parents(splat s, uint corners)
{
    const uvec3 near = uvec3(0x55u, 0x33u, 0x0Fu);
    for (int k = 0; k < 3; k++)
        if ((s.cell[k] & 1) == 0)
            corners = (corners | corners >> (1 << k)) & near[k];
    return corners;
}

// Page words of a splat: cells from -1 are stored one higher.
uint splat_pack_cell(splat s)
{
    return cell_pack(uvec3(s.cell + 1));
}

uint splat_pack_fraction(splat s)
{
    return s.fraction.x | (s.fraction.y << 8) | (s.fraction.z << 16);
}

splat splat_unpack(uint cell, uint fraction)
{
    splat s;
    s.cell = ivec3(cell_unpack(cell)) - 1;
    s.fraction = uvec3(fraction, fraction >> 8, fraction >> 16) & 255u;
    return s;
}
