// Brings the cached voxels of the dynamic layer to the world: rigid by the object's matrix, skinned by the blend of the voxel's own
// weights, attached (morphing) by the surface point that it is tied to. Writes the page voxel and, unless KD_UNMARKED, marks the
// cells that it covers in the layer's mask.
//
// One row of work groups a segment; empty slots end at once.
// Source: Yalciner 2016, section 4.3 (transformation) and 4.7; the coverage splat is ours.
layout(local_size_x = 128) in;

#include "shaders/include/splat.glsl"
#include "shaders/include/rigid.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/shared/scene.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 2) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(std430, binding = 3) readonly buffer shape_block { uvec2 shape[]; };
layout(std430, binding = 4) readonly buffer binding_block { uint binding_words[]; };
layout(std430, binding = 5) writeonly buffer voxels_block { uint voxels[]; };
#ifndef KD_UNMARKED
layout(std430, binding = 6) buffer mask_block { uint mask[]; };
#endif
layout(binding = 0) uniform samplerBuffer joint_rows;    // rgba32f, three rows a joint
layout(binding = 1) uniform usamplerBuffer deformed;     // r32ui: the geometry stream
layout(binding = 2) uniform usamplerBuffer index_stream; // r32ui

struct posed {
    vec3 position_ws;
    vec3 normal_ws;
};

posed pose_rigid(kd_voxel_object_params o, vec3 p, vec3 n)
{
    return posed(rigid_position(o, p), rigid_normal(o, n));
}

posed pose_skinned(kd_voxel_object_params o, uint binding_at, vec3 p, vec3 n)
{
    uint at = binding_at * KD_BINDING_WORDS;
    uint low = binding_words[at], high = binding_words[at + 1u];
    uvec4 joint = uvec4(low & 0xFFFFu, low >> 16, high & 0xFFFFu, high >> 16) + o.info.y;
    vec4 weight = unpackUnorm4x8(binding_words[at + 2u]);
    weight /= dot(weight, vec4(1.0));
    vec4 r0 = vec4(0.0), r1 = vec4(0.0), r2 = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        int row = int(joint[k]) * 3;
        r0 += weight[k] * texelFetch(joint_rows, row);
        r1 += weight[k] * texelFetch(joint_rows, row + 1);
        r2 += weight[k] * texelFetch(joint_rows, row + 2);
    }
    vec4 p1 = vec4(p, 1.0);
    // Normals go by the cofactors of the blended matrix: right for any stretch.
    vec3 c0 = cross(r1.xyz, r2.xyz), c1 = cross(r2.xyz, r0.xyz), c2 = cross(r0.xyz, r1.xyz);
    float side = dot(r0.xyz, c0) < 0.0 ? -1.0 : 1.0; // mirrored joints turn surfaces inside out
    return posed(vec3(dot(r0, p1), dot(r1, p1), dot(r2, p1)), side * vec3(dot(c0, n), dot(c1, n), dot(c2, n)));
}

vec3 deformed_position(uint vertex)
{
    int at = int(vertex) * KD_GEOMETRY_WORDS;
    return uintBitsToFloat(uvec3(texelFetch(deformed, at).r, texelFetch(deformed, at + 1).r, texelFetch(deformed, at + 2).r));
}

vec3 deformed_normal(uint vertex)
{
    int at = int(vertex) * KD_GEOMETRY_WORDS + 3;
    return vec3(unpackSnorm2x16(texelFetch(deformed, at).r), unpackSnorm2x16(texelFetch(deformed, at + 1).r).x);
}

posed pose_attached(kd_voxel_object_params o, uint binding_at)
{
    uint at = binding_at * KD_BINDING_WORDS;
    int first = int(o.info.z + binding_words[at] * 3u);
    vec2 yz = unpackUnorm2x16(binding_words[at + 1u]);
    vec3 bary = vec3(1.0 - yz.x - yz.y, yz);
    vec3 p = vec3(0.0), n = vec3(0.0);
    for (int k = 0; k < 3; k++) {
        uint vertex = o.info.w + texelFetch(index_stream, first + k).r;
        p += bary[k] * deformed_position(vertex);
        n += bary[k] * deformed_normal(vertex);
    }
    return pose_rigid(o, p, n);
}

#ifndef KD_UNMARKED
void mark(uint c, splat s)
{
    uint first = cascade_first_bit(c);
    for (uint corners = splat_corners(s, c); corners != 0u; corners &= corners - 1u) {
        uint bit = first + morton_encode(cell_wrap(c, splat_cell(s, uint(findLSB(corners)))));
        atomicOr(mask[bit >> 5], 1u << (bit & 31u));
    }
}
#endif

void main()
{
    uint slot = gl_WorkGroupID.y, i = gl_GlobalInvocationID.x;
    kd_voxel_segment segment = segments[slot];
    if (i >= segment.count)
        return;
    uint c = segment.chunk_cascade >> 28;
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    kd_voxel_object_params o = objects[segment.object];
    uvec2 cached = shape[segment.first + i];
    vec3 p = rigid_model_position(chunk, cached.x);
    vec3 n = vec3(snorm8_unpack(cached.y)) / 127.0;
    uint binding_at = chunk.info.z + segment.first + i - chunk.info.x;
    posed v = o.info.x == KD_VOXEL_RIGID ? pose_rigid(o, p, n)
            : o.info.x == KD_VOXEL_SKINNED ? pose_skinned(o, binding_at, p, n) : pose_attached(o, binding_at);
    uint at = (slot * KD_SEGMENT_VOXELS + i) * 3u;
    precise vec3 position = v.position_ws / tree.cascade[c].w;
    if (!splat_inside(c, position)) {
        voxels[at] = KD_NO_VOXEL;
        return;
    }
    splat s = splat_at(c, position);
    voxels[at] = splat_pack_cell(s);
    voxels[at + 1u] = splat_pack_fraction(s);
    voxels[at + 2u] = rigid_pack_normal(v.normal_ws, length(n));
#ifndef KD_UNMARKED
    mark(c, s);
#endif
}
