// Sums of a cell to attributes of 16 bytes (cell_attributes.glsl unpacks them):
// albedo 3 x 10 bits, share of double-sided voxels 2 bits | normal 3 x snorm8, weight 8 bits: 1 … 256, what is more counts as
// that | emission 3 x 9 bits, halvings 5 | area of what glows 16 bits. The last two are 0 where nothing glows.
// In integers throughout: every driver makes the same bytes, and so does systems/svo/reference.c.
layout(std430, binding = 1) readonly buffer sums_block { uint sums[]; };

uint mean(uint sum, uint weight) { return (sum + weight / 2u) / weight; }

uint mean_signed(uint sum, uint weight)
{
    int s = int(sum);
    return (s < 0 ? 0u - mean(uint(-s), weight) : mean(sum, weight)) & 255u;
}

// Surfaces beside each other share a cell's emission by coverage; a lamp that lies on a ceiling, so that the two cover the
// cell twice, shines as brightly as one alone.
uint emission_weight(uint weight, uint emissive) { return max(max(min(weight, 256u), emissive), 1u); }

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
    for (int k = 0; k < 3; k++)
        word |= min(mean(((sum[k] * 256u << halvings) >> spare) * 511u, one >> spare), 511u) << (9 * k);
    return word | halvings << 27;
}

// Area that glows with the cell's emission, 256 KD_AREA_ONE a face: what glows may share the cell's emission with what does not.
uint pack_area(uint area, uint emissive, uint shared_by)
{
    return emissive == 0u ? 0u : min(mean(area, emissive) * shared_by, 65535u);
}

uvec4 cell_attributes_of(uint cell)
{
    uint at = cell * KD_SUM_WORDS;
    uint weight = max(sums[at], 1u);
    uint albedo = mean(sums[at + 1u], weight) | mean(sums[at + 2u], weight) << 10 | mean(sums[at + 3u], weight) << 20;
    uint normal = mean_signed(sums[at + 4u], weight) | mean_signed(sums[at + 5u], weight) << 8 |
                  mean_signed(sums[at + 6u], weight) << 16;
    uint shared_by = emission_weight(sums[at], sums[at + 11u]), area = pack_area(sums[at + 12u], sums[at + 11u], shared_by);
    uint emission = pack_emission(uvec3(sums[at + 7u], sums[at + 8u], sums[at + 9u]), shared_by);
    return uvec4(albedo | mean(sums[at + 10u] * 3u, weight) << 30, normal | (min(weight, 256u) - 1u) << 24, emission, area);
}
