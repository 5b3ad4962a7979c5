// The atlas of dense levels as the filter reads and writes it; layout: KD_ATLAS_BLOCK in shaders/shared/voxel.h. All of it is
// rgb9e5. Radiance is weighted by the depth as it is stored, so what rounding does to depths changes no colour.

#include "shaders/include/half_pack.glsl"

layout(binding = 0, r32ui) uniform uimage3D atlas;       // tau S
layout(binding = 1, r32ui) uniform uimage3D atlas_depth; // tau

// Where a cell lies, and how many slices further each part of the atlas has it.
struct atlas_cell {
    ivec3 radiance, depth;
    int parts_apart;
    int copy; // slices to where it lies once more, beyond its block's end; 0: nowhere
};

// cell: wrapped, of cascade c
atlas_cell atlas_place(uint c, ivec3 cell)
{
    int copy = cell.z == 0 ? KD_DENSE : cell.z == KD_DENSE - 1 ? -KD_DENSE : 0;
    return atlas_cell(cell + ivec3(0, 0, int(c) * 6 * KD_ATLAS_BLOCK + 1), cell + ivec3(0, 0, int(c) * 2 * KD_ATLAS_BLOCK + 1),
                      KD_ATLAS_BLOCK, copy);
}

// Level `mip` above the outermost of n cascades: 32 cells an edge, 16 …
atlas_cell atlas_place_above(uint n, uint mip, ivec3 cell)
{
    ivec3 at = cell + ivec3(0, KD_DENSE - (2 * KD_DENSE >> mip), 0);
    return atlas_cell(at + ivec3(0, 0, int(n) * 6 * KD_ATLAS_BLOCK), at + ivec3(0, 0, int(n) * 2 * KD_ATLAS_BLOCK), KD_DENSE / 2, 0);
}

// Depths of rays towards +x +y +z, or the other way.
vec3 atlas_load_depth(atlas_cell at, int reverse)
{
    return rgb9e5_unpack(imageLoad(atlas_depth, at.depth + ivec3(0, 0, reverse * at.parts_apart)).r);
}

vec3 atlas_load_radiance(atlas_cell at, int direction)
{
    return rgb9e5_unpack(imageLoad(atlas, at.radiance + ivec3(0, 0, direction * at.parts_apart)).r);
}

void atlas_put_radiance(atlas_cell at, int direction, vec4 seen, float stored)
{
    uint word = stored > 0.0 ? rgb9e5_pack(seen.rgb * (stored / seen.a)) : 0u;
    ivec3 to = at.radiance + ivec3(0, 0, direction * at.parts_apart);
    imageStore(atlas, to, uvec4(word));
    if (at.copy != 0)
        imageStore(atlas, to + ivec3(0, 0, at.copy), uvec4(word));
}

// Three directions: towards +x +y +z, or the other way.
void atlas_put(atlas_cell at, int reverse, vec4 x, vec4 y, vec4 z)
{
    uint word = rgb9e5_pack(vec3(x.a, y.a, z.a));
    vec3 stored = rgb9e5_unpack(word);
    ivec3 to = at.depth + ivec3(0, 0, reverse * at.parts_apart);
    imageStore(atlas_depth, to, uvec4(word));
    if (at.copy != 0)
        imageStore(atlas_depth, to + ivec3(0, 0, at.copy), uvec4(word));
    atlas_put_radiance(at, reverse, x, stored.x);
    atlas_put_radiance(at, 2 + reverse, y, stored.y);
    atlas_put_radiance(at, 4 + reverse, z, stored.z);
}
