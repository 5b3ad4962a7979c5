// Voxelization, pass 2: add every fragment's attributes to its voxel, weighted by how near the surface passes the centre.
// 16-bit attributes in sums of 64 bits: exact, however many fragments there are and in whatever order they come.
layout(local_size_x = 64) in;

layout(std430, binding = 4) readonly buffer mask_block { uint mask[]; };
layout(std430, binding = 5) readonly buffer ranks_block { uint ranks[]; };
// 16 words a voxel: weight, then low words of 3 albedo, 3 normal, emission, then their high words, then the area of what glows;
// in a buffer of its own one word a voxel: nearest triangle (see below).
layout(std430, binding = 6) buffer sums_block { uint sums[]; };
layout(std430, binding = 7) buffer nearest_block { uint nearest[]; };

void fragment(uint triangle, uvec3 cell, vec3 bary);

#include "shaders/include/linear.glsl"
bool keeps_cell(uvec3 cell, uint creases, vec3 a, vec3 b, vec3 c);

#include "shaders/voxel_cache/triangle.glsl"
#include "shaders/voxel_cache/surface.glsl"
#include "shaders/voxel_cache/chunk_cell.glsl"
#ifdef KD_GLOWS
#include "shaders/voxel_cache/area.glsl"
#endif

void add(uint at, float value, uint weight)
{
    uint more = uint(round(clamp(value, 0.0, 1.0) * 65535.0)) * weight;
    uint before = atomicAdd(sums[at], more);
    if (before + more < before)
        atomicAdd(sums[at + 7u], 1u);
}

void fragment(uint triangle, uvec3 cell, vec3 bary)
{
    fragment_surface s = fragment_load(triangle, bary);
    if (!fragment_opaque(s))
        return;
    vec3 point = bary.x * cell_position(vertex_of(triangle, 0u)) + bary.y * cell_position(vertex_of(triangle, 1u)) +
                 bary.z * cell_position(vertex_of(triangle, 2u));
    float nearness = clamp(1.0 - distance(point, vec3(cell) + 0.5) / 0.8660254, 0.0, 1.0);
    uint weight = 1u + uint(nearness * 15.0);
    uint bit = chunk_bit(pass.chunk_size.xyz, cell);
    uint voxel = ranks[bit >> 5] + uint(bitCount(mask[bit >> 5] & ((1u << (bit & 31u)) - 1u)));
    vec3 normal = normalize(s.normal + vec3(0, 1e-12, 0)) * 0.5 + 0.5;
    uint at = voxel * 16u;
    atomicAdd(sums[at], weight);
    for (uint k = 0u; k < 3u; k++) {
        add(at + 1u + k, s.base_color[k], weight);
        add(at + 4u + k, normal[k], weight);
    }
    add(at + 7u, s.emission, weight);
#ifdef KD_GLOWS
    atomicAdd(sums[at + 15u], uint(round(area_in_cell(cell, triangle) * 4096.0)));
#endif
    // The nearest surface binds a deforming voxel: largest nearness (6 bits), then the lowest triangle.
    if (pass.dest.z != KD_VOXEL_RIGID)
        atomicMax(nearest[voxel], (uint(nearness * 62.0) + 1u) << 26 | (0x3FFFFFFu - triangle));
}

// All that touches a cell that was taken adds to it.
bool keeps_cell(uvec3 cell, uint creases, vec3 a, vec3 b, vec3 c)
{
    uint bit = chunk_bit(pass.chunk_size.xyz, cell);
    return (mask[bit >> 5] >> (bit & 31u) & 1u) != 0u;
}

void main()
{
    uint column = linear_index();
    if (column < pass.chunk_size.w)
        visit_column(column);
}
