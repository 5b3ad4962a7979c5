// What a voxel adds to the sums of a cell, before the weight, in integers: colour word and emission of the cached voxel.

// Linear, 10 bits.
uvec3 share_albedo(uint color)
{
    uvec3 root = uvec3(color, color >> 8, color >> 16) & 255u;
    return (root * root * 1023u + 32512u) / 65025u;
}

uint share_double_sided(uint color) { return color >> 24 & 1u; }

// Of what glows.
uint share_area(uint color) { return color >> 25; }

// KD_EMISSION_ONE is the brightest of the scene. emissive: of the object, relative to the brightest
uvec3 share_emission(uint share, vec3 emissive)
{
    return (uvec3(emissive * KD_EMISSION_ONE + 0.5) * share + 127u) / 255u;
}
