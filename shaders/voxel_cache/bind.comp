// Voxelization, pass 4, for deforming meshes: tie every voxel to the surface point nearest to its centre. A skinned voxel
// gets that point's joint weights (barycentric, not those of the nearest vertex); a morphing one the triangle itself.
layout(local_size_x = 64) in;

layout(std430, binding = 3) readonly buffer mask_block { uint mask[]; };
layout(std430, binding = 4) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 5) readonly buffer nearest_block { uint nearest[]; };
layout(std430, binding = 6) readonly buffer skin_block { uint skin[]; };
layout(std430, binding = 7) writeonly buffer binding_block { uint binding_words[]; };

#include "shaders/shared/voxel.h"
#include "shaders/shared/scene.h"

layout(std140, binding = 0) uniform pass_block {
    vec4 chunk_origin;
    uvec4 chunk_size; // xyz: cells, w: mask words
    uvec4 source;     // x: first index, y: base vertex, w: first skin vertex
    uvec4 dest;       // y: first binding, z: KD_VOXEL_*
} pass;

layout(std430, binding = 0) readonly buffer geometry_block { uint geometry[]; };
layout(std430, binding = 2) readonly buffer indices_block { uint indices[]; };

#include "shaders/include/linear.glsl"
#include "shaders/include/triangle_point.glsl"
#include "shaders/voxel_cache/chunk_cell.glsl"

vec3 cell_position(uint vertex)
{
    uint at = vertex * uint(KD_GEOMETRY_WORDS);
    vec3 p = uintBitsToFloat(uvec3(geometry[at], geometry[at + 1u], geometry[at + 2u]));
    return (p - pass.chunk_origin.xyz) / pass.chunk_origin.w + KD_VOXELIZE_NUDGE;
}

// The four largest of the three corners' joint weights, blended by the barycentric coordinates.
void bind_skin(uint at, uvec3 corner, vec3 bary)
{
    uint joint[12];
    float weight[12];
    int count = 0;
    for (int v = 0; v < 3; v++) {
        uint s = (pass.source.w + corner[v]) * uint(KD_SKIN_WORDS);
        uvec4 j = uvec4(skin[s] & 0xFFFFu, skin[s] >> 16, skin[s + 1u] & 0xFFFFu, skin[s + 1u] >> 16);
        vec4 w = vec4(unpackUnorm2x16(skin[s + 2u]), unpackUnorm2x16(skin[s + 3u])) * bary[v];
        for (int k = 0; k < 4; k++) {
            int slot = count;
            for (int i = 0; i < count; i++)
                if (joint[i] == j[k])
                    slot = i;
            if (slot == count) {
                joint[count] = j[k];
                weight[count++] = 0.0;
            }
            weight[slot] += w[k];
        }
    }
    uvec4 best_joint = uvec4(0u);
    vec4 best_weight = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        int best = 0;
        for (int i = 1; i < count; i++)
            if (weight[i] > weight[best])
                best = i;
        best_joint[k] = joint[best];
        best_weight[k] = max(weight[best], 0.0);
        weight[best] = -1.0;
    }
    float sum = dot(best_weight, vec4(1.0));
    binding_words[at] = best_joint.x | best_joint.y << 16;
    binding_words[at + 1u] = best_joint.z | best_joint.w << 16;
    binding_words[at + 2u] = packUnorm4x8(sum > 0.0 ? best_weight / sum : vec4(1, 0, 0, 0));
}

void bind(uint voxel, uint from, uint bit)
{
    uvec3 cell = chunk_cell(pass.chunk_size.xyz, bit);
    uint triangle = 0x3FFFFFFu - (nearest[from] & 0x3FFFFFFu);
    uint first = pass.source.x + triangle * 3u;
    uvec3 corner = uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
    uvec3 vertex = corner + pass.source.y;
    vec3 bary = nearest_barycentric(vec3(cell) + 0.5, cell_position(vertex.x), cell_position(vertex.y), cell_position(vertex.z));
    uint at = (pass.dest.y + voxel) * KD_BINDING_WORDS;
    if (pass.dest.z == KD_VOXEL_SKINNED) {
        bind_skin(at, corner, bary);
        return;
    }
    binding_words[at] = triangle;
    binding_words[at + 1u] = packUnorm2x16(bary.yz);
    binding_words[at + 2u] = 0u;
}

void main()
{
    uint word = linear_index();
    if (word >= pass.chunk_size.w)
        return;
    uint bits = mask[word], voxel = ranks[word], from = voxel;
    if (bits == 0u)
        return;
    while (from > 0u && nearest[from] == 0u) // inside of a filled mesh: a surface before it; there is one to the left
        from--;
    while (bits != 0u) {
        from = nearest[voxel] != 0u ? voxel : from;
        bind(voxel, from, word * 32u + uint(findLSB(bits)));
        bits &= bits - 1u;
        voxel++;
    }
}
