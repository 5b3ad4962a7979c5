// What a fragment sees of its triangle: colour, opacity and emission, read at the mip level whose texels are as large as a voxel.

#include "shaders/include/material_maps.glsl"

vec2 uv_of(uint vertex, uint set)
{
    uint at = vertex * uint(KD_ATTRIBUTE_WORDS) + 2u * set;
    return uintBitsToFloat(uvec2(attributes[at], attributes[at + 1u]));
}

vec4 color_of(uint vertex)
{
    return unpackUnorm4x8(attributes[vertex * uint(KD_ATTRIBUTE_WORDS) + 4u]);
}

// Mip level at which one texel is about one voxel wide: from the triangle's areas in texels and in cells.
float level_of(vec2 a, vec2 b, vec2 c, float cells_area2, vec2 texels)
{
    vec2 e = (b - a) * texels, f = (c - a) * texels;
    float texels_area2 = abs(e.x * f.y - e.y * f.x);
    return 0.5 * log2(max(texels_area2 / max(cells_area2, 1e-6), 1.0));
}

struct fragment_surface {
    vec4 base_color;
    vec3 normal;
    float emission; // share of the material's emissive colour
};

vec3 normal_of(uint vertex)
{
    uint at = vertex * uint(KD_GEOMETRY_WORDS) + 3u;
    return vec3(unpackSnorm2x16(geometry[at]), unpackSnorm2x16(geometry[at + 1u]).x);
}

fragment_surface fragment_load(uint triangle, vec3 bary)
{
    uint i0 = vertex_of(triangle, 0u), i1 = vertex_of(triangle, 1u), i2 = vertex_of(triangle, 2u);
    vec3 p0 = cell_position(i0), p1 = cell_position(i1), p2 = cell_position(i2);
    float area2 = length(cross(p1 - p0, p2 - p0));
    fragment_surface s;
    s.base_color = material.base_color * (bary.x * color_of(i0) + bary.y * color_of(i1) + bary.z * color_of(i2));
    s.base_color.rgb *= 1.0 - material.lobes.z; // what passes through is not scattered back
    s.normal = bary.x * normal_of(i0) + bary.y * normal_of(i1) + bary.z * normal_of(i2);
    s.emission = 1.0;
    if ((material.maps.x & KD_MAP_BASE_COLOR) != 0u) {
        vec2 a = map_uv(0u, uv_of(i0, 0u), uv_of(i0, 1u)), b = map_uv(0u, uv_of(i1, 0u), uv_of(i1, 1u));
        vec2 c = map_uv(0u, uv_of(i2, 0u), uv_of(i2, 1u));
        s.base_color *= textureLod(base_color_map, bary.x * a + bary.y * b + bary.z * c, level_of(a, b, c, area2, vec2(textureSize(base_color_map, 0))));
    }
    if ((material.maps.x & KD_MAP_EMISSIVE) != 0u) {
        vec2 a = map_uv(3u, uv_of(i0, 0u), uv_of(i0, 1u)), b = map_uv(3u, uv_of(i1, 0u), uv_of(i1, 1u));
        vec2 c = map_uv(3u, uv_of(i2, 0u), uv_of(i2, 1u));
        vec3 e = textureLod(emissive_map, bary.x * a + bary.y * b + bary.z * c, level_of(a, b, c, area2, vec2(textureSize(emissive_map, 0)))).rgb;
        s.emission = dot(e, vec3(1.0 / 3.0));
    }
    return s;
}

// Masked parts leave no voxels. The cutoff is negative for materials without a mask.
bool fragment_opaque(fragment_surface s)
{
    return s.base_color.a >= material.emissive.a;
}
