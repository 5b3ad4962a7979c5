// Order of a chunk's cells in its mask, and so of its voxels: blocks of 8x8x8 in rows along x, y, z, Morton order inside.
// Voxels that follow each other lie close together, whatever their surface, and a few of them have a small box.

#include "shaders/include/morton.glsl"

uint chunk_bit(uvec3 size, uvec3 cell)
{
    uvec3 blocks = (size + 7u) >> 3, block = cell >> 3;
    return (block.x + blocks.x * (block.y + blocks.y * block.z)) << 9 | morton_encode(cell & 7u);
}

uvec3 chunk_cell(uvec3 size, uint bit)
{
    uvec3 blocks = (size + 7u) >> 3;
    uint block = bit >> 9;
    uvec3 at = uvec3(block % blocks.x, block / blocks.x % blocks.y, block / (blocks.x * blocks.y));
    return at << 3 | morton_decode(bit & 511u);
}
