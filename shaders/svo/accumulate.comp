// Adds the attributes of a layer's page voxels to the cells that they cover: integers, weighted by coverage, so that the
// sums are the same in whatever order the threads come. The cell's place in the sums is the rank of its mask bit.
layout(local_size_x = 128) in;

#include "shaders/include/splat.glsl"
#include "shaders/include/morton.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots, y: capacity of the sums
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 2) readonly buffer shape_block { uvec2 shape[]; };
layout(std430, binding = 3) readonly buffer color_block { uint color[]; };
layout(std430, binding = 4) readonly buffer voxels_block { uint voxels[]; };
layout(std430, binding = 5) readonly buffer mask_block { uint mask[]; };
layout(std430, binding = 6) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 7) buffer sums_block { uint sums[]; };

void add(uint at, uint weight, uvec3 albedo, ivec3 normal, uvec3 emission, uint double_sided)
{
    atomicAdd(sums[at], weight);
    atomicAdd(sums[at + 1u], albedo.x * weight);
    atomicAdd(sums[at + 2u], albedo.y * weight);
    atomicAdd(sums[at + 3u], albedo.z * weight);
    atomicAdd(sums[at + 4u], uint(normal.x * int(weight)));
    atomicAdd(sums[at + 5u], uint(normal.y * int(weight)));
    atomicAdd(sums[at + 6u], uint(normal.z * int(weight)));
    if (emission != uvec3(0u)) {
        atomicAdd(sums[at + 7u], (emission.x * weight + 128u) >> 8);
        atomicAdd(sums[at + 8u], (emission.y * weight + 128u) >> 8);
        atomicAdd(sums[at + 9u], (emission.z * weight + 128u) >> 8);
        atomicAdd(sums[at + 11u], weight);
    }
    if (double_sided != 0u)
        atomicAdd(sums[at + 10u], weight);
}

void main()
{
    uint slot = gl_WorkGroupID.y, i = gl_GlobalInvocationID.x;
    kd_voxel_segment segment = segments[slot];
    if (i >= segment.count)
        return;
    uint from = (slot * KD_SEGMENT_VOXELS + i) * 3u;
    uint cell_word = voxels[from];
    if (cell_word == KD_NO_VOXEL)
        return;
    splat s = splat_unpack(cell_word, voxels[from + 1u]);
    ivec3 normal = snorm8_unpack(voxels[from + 2u]);
    uint color_word = color[segment.first + i];
    uvec3 root = uvec3(color_word, color_word >> 8, color_word >> 16) & 255u;
    uvec3 albedo = (root * root * 1023u + 32512u) / 65025u;
    uint share = shape[segment.first + i].y >> 24;
    uvec3 emission = (uvec3(objects[segment.object].emission.rgb * KD_EMISSION_ONE + 0.5) * share + 127u) / 255u;
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c);
    for (uint k = 0u; k < 8u; k++) {
        uint weight = splat_weight(s, k);
        ivec3 cell = splat_cell(s, k);
        if (weight < SPLAT_MIN_WEIGHT || !splat_owned(c, cell))
            continue;
        uint bit = first + morton_encode(uvec3(cell));
        uint rank = ranks[bit >> 5] + uint(bitCount(mask[bit >> 5] & ((1u << (bit & 31u)) - 1u)));
        if (rank < pass.y)
            add(rank * KD_SUM_WORDS, weight, albedo, normal, emission, color_word & 0x1000000u);
    }
}
