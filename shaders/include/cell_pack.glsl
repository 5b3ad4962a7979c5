// Sums of a cell to attributes of 16 bytes (cell_attributes.glsl unpacks them):
// albedo 3 x 10 bits, share of double-sided voxels 2 bits | normal 3 x snorm8, or of what is thin an octahedral axis, 2 x snorm8;
// weight 7 bits: 127 a whole voxel or more of them, thin 1 bit: as a leaf has it (tree_node.glsl) | emission 3 x 9 bits, halvings 5 |
// area of what glows 16 bits. The last two are 0 where nothing glows.
// In integers throughout: every driver makes the same bytes, and so does systems/svo/reference.c.
// given_up: levels (cascade_given_up of tree_params.glsl); a face of such a cell takes four times as many voxels for each.

#include "shaders/include/axis.glsl"

// sum / weight, rounded. Drivers divide integers lane by lane; a float comes within one of the quotient, the remainder says
// which way. For quotients below 2^16.
uint mean(uint sum, uint weight)
{
    uint n = sum + weight / 2u, q = uint(float(n) / float(weight));
    int rest = int(n - q * weight);
    return rest < 0 ? q - 1u : rest >= int(weight) ? q + 1u : q;
}

int mean_signed(int sum, uint weight)
{
    int m = int(mean(uint(abs(sum)), weight));
    return sum < 0 ? -m : m;
}

ivec3 mean_normal(ivec3 sum, uint weight)
{
    return ivec3(mean_signed(sum.x, weight), mean_signed(sum.y, weight), mean_signed(sum.z, weight));
}

int square_of(ivec3 v) { return v.x * v.x + v.y * v.y + v.z * v.z; }

// Squares of lengths in snorm8. Normals whose mean is as long agree; axes whose mean is as long are those of one surface.
const int AGREED = 102 * 102, ONE_AXIS = 64 * 64;

// octahedral.glsl reads it.
uint octahedral_pack_snorm8(ivec3 n)
{
    ivec3 a = abs(n);
    uint sum = uint(max(a.x + a.y + a.z, 1));
    int u = int(mean(uint(a.x) * 127u, sum)), v = int(mean(uint(a.y) * 127u, sum));
    ivec2 e = n.z < 0 ? ivec2(127 - v, 127 - u) : ivec2(u, v);
    return (uint(n.x < 0 ? -e.x : e.x) & 255u) | (uint(n.y < 0 ? -e.y : e.y) & 255u) << 8;
}

uint snorm8_word(ivec3 n) { return (uint(n.x) & 255u) | (uint(n.y) & 255u) << 8 | (uint(n.z) & 255u) << 16; }

// Albedo, share of what is double-sided, normal and weight. axes: sum of the axes, asked for where normals do not agree
uvec2 cell_pack_surface(uint weight, uvec3 albedo, ivec3 normal, ivec3 axes, uint double_sided, uint given_up)
{
    weight = max(weight, 1u);
    uint covered = min(weight >> (2u * given_up), 256u), covers = max((covered * 127u + 128u) >> 8, 1u);
    uint both_sides = mean(double_sided * 3u, weight);
    ivec3 n = mean_normal(normal, weight), axis = square_of(n) < AGREED ? mean_normal(axes, weight) : n;
    bool thin = square_of(axis) >= ONE_AXIS && (both_sides > 1u || 25 * square_of(n) < 9 * square_of(axis));
    return uvec2(mean(albedo.x, weight) | mean(albedo.y, weight) << 10 | mean(albedo.z, weight) << 20 | both_sides << 30,
                 (thin ? octahedral_pack_snorm8(axis) : snorm8_word(n)) | covers << 24 | uint(thin) << 31);
}

// One shared scale keeps dim emission next to bright.
uint pack_emission(uvec3 sum, uint weight)
{
    uint one = uint(KD_EMISSION_ONE) * weight;
    uint top = max(sum.x, max(sum.y, sum.z)), halvings = 0u, spare = 0u, word = 0u;
    if (top == 0u)
        return 0u;
    while (halvings < 31u && top * 256u <= one >> (halvings + 1u))
        halvings++;
    while (one >> spare >= 1u << 22)
        spare++;
    for (int k = 0; k < 3; k++) {
        uint n = ((sum[k] * 256u << halvings) >> spare) * 511u, d = one >> spare;
        word |= min((n + d / 2u) / d, 511u) << (9 * k);
    }
    return word | halvings << 27;
}

// Emission and area. Surfaces beside each other share a cell's emission by coverage; a lamp that lies on a ceiling, so
// that the two cover the cell twice, shines as brightly as one alone. Area glows with the cell's emission, 256 KD_AREA_ONE a
// face: what glows may share the cell's emission with what does not.
uvec2 cell_pack_emission(uint weight, uvec3 emission, uint emissive, uint area, uint given_up)
{
    uint faces = 2u * given_up;
    weight >>= faces;
    emission >>= faces;
    area >>= faces;
    emissive = min(emissive, max(emissive >> faces, 1u));
    uint shared_by = max(max(min(weight, 256u), emissive), 1u);
    return uvec2(pack_emission(emission, shared_by), emissive == 0u ? 0u : min((area + emissive / 2u) / emissive * shared_by, 65535u));
}
