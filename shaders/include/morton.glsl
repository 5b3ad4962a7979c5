// Morton order: bit 0 is x, bit 1 is y, bit 2 is z, so that eight siblings are consecutive and a node's children follow
// from its own code by 8 * code + octant. Up to 10 bits an axis.

uint morton_spread(uint v)
{
    v = (v | (v << 16)) & 0x030000FFu;
    v = (v | (v << 8)) & 0x0300F00Fu;
    v = (v | (v << 4)) & 0x030C30C3u;
    return (v | (v << 2)) & 0x09249249u;
}

uint morton_gather(uint v)
{
    v &= 0x09249249u;
    v = (v | (v >> 2)) & 0x030C30C3u;
    v = (v | (v >> 4)) & 0x0300F00Fu;
    v = (v | (v >> 8)) & 0x030000FFu;
    return (v | (v >> 16)) & 0x3FFu;
}

uint morton_encode(uvec3 cell)
{
    return morton_spread(cell.x) | (morton_spread(cell.y) << 1) | (morton_spread(cell.z) << 2);
}

uvec3 morton_decode(uint code)
{
    return uvec3(morton_gather(code), morton_gather(code >> 1), morton_gather(code >> 2));
}
