// The atlas of dense levels as the filter reads and writes it; layout: KD_ATLAS_BLOCK in shaders/shared/voxel.h.
layout(binding = 0, rgba16f) uniform image3D atlas;

// cell: wrapped, of cascade c
ivec3 atlas_place(uint c, ivec3 cell, int direction)
{
    return cell + ivec3(0, 0, (int(c) * 6 + direction) * KD_ATLAS_BLOCK + 1);
}

void atlas_store(uint c, ivec3 cell, int direction, vec4 value)
{
    ivec3 at = atlas_place(c, cell, direction);
    imageStore(atlas, at, value);
    if (cell.z == 0 || cell.z == KD_DENSE - 1)
        imageStore(atlas, at + ivec3(0, 0, cell.z == 0 ? KD_DENSE : -KD_DENSE), value);
}

// Level `mip` above the outermost of n cascades: 32 cells an edge, 16 …
ivec3 atlas_place_above(uint n, uint mip, ivec3 cell, int direction)
{
    return cell + ivec3(0, KD_DENSE - (2 * KD_DENSE >> mip), int(n) * 6 * KD_ATLAS_BLOCK + direction * (KD_DENSE / 2));
}
