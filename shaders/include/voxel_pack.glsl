// Packing of voxel words; the layouts stand in shaders/shared/voxel.h.

uint cell_pack(uvec3 cell)
{
    return cell.x | (cell.y << 10) | (cell.z << 20);
}

uvec3 cell_unpack(uint word)
{
    return uvec3(word & 1023u, (word >> 10) & 1023u, (word >> 20) & 1023u);
}

ivec3 snorm8_unpack(uint word)
{
    return ivec3(int(word << 24) >> 24, int(word << 16) >> 24, int(word << 8) >> 24);
}

uint snorm8_pack(vec3 v)
{
    ivec3 i = ivec3(round(clamp(v, -1.0, 1.0) * 127.0));
    return (uint(i.x) & 255u) | ((uint(i.y) & 255u) << 8) | ((uint(i.z) & 255u) << 16);
}

// Albedo is kept as its square root: even steps for the eye, and dark values survive eight bits.
uint albedo_pack(vec3 albedo)
{
    uvec3 c = uvec3(round(sqrt(clamp(albedo, 0.0, 1.0)) * 255.0));
    return c.x | (c.y << 8) | (c.z << 16);
}

vec3 albedo_unpack(uint word)
{
    vec3 c = vec3(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u) * (1.0 / 255.0);
    return c * c;
}
