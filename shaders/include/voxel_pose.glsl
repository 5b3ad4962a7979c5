// Cached voxels in their object's pose: rigid by the object's matrix, skinned by the blend of the voxel's own weights, attached
// (morphing) by the surface point that they are tied to.
// Source: Yalciner 2016, section 4.3 (transformation).

#include "shaders/shared/scene.h"
#include "shaders/shared/voxel.h"
#include "shaders/include/voxel_pack.glsl"
#include "shaders/include/rigid.glsl"

layout(binding = 0) uniform samplerBuffer joint_rows;    // rgba32f, three rows a joint
layout(binding = 1) uniform usamplerBuffer deformed;     // r32ui: the geometry stream
layout(binding = 2) uniform usamplerBuffer index_stream; // r32ui
layout(binding = 3) uniform usamplerBuffer bindings;     // r32ui, three words a voxel

uint binding_word(uint binding_at, uint k)
{
    return texelFetch(bindings, int(binding_at * KD_BINDING_WORDS + k)).r;
}

struct posed {
    vec3 position_ws;
    vec3 normal_ws;
    mat3 axes; // model to world, round the voxel
};

posed pose_rigid(kd_voxel_object_params o, vec3 p, vec3 n)
{
    mat3 rows = mat3(o.model_ws[0].xyz, o.model_ws[1].xyz, o.model_ws[2].xyz);
    return posed(rigid_position(o, p), rigid_normal(o, n), transpose(rows));
}

posed pose_skinned(uint first_joint, uint binding_at, vec3 p, vec3 n)
{
    uint low = binding_word(binding_at, 0u), high = binding_word(binding_at, 1u);
    uvec4 joint = uvec4(low & 0xFFFFu, low >> 16, high & 0xFFFFu, high >> 16) + first_joint;
    vec4 weight = unpackUnorm4x8(binding_word(binding_at, 2u));
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
    return posed(vec3(dot(r0, p1), dot(r1, p1), dot(r2, p1)), side * vec3(dot(c0, n), dot(c1, n), dot(c2, n)),
                 transpose(mat3(r0.xyz, r1.xyz, r2.xyz)));
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
    int first = int(o.info.z + binding_word(binding_at, 0u) * 3u);
    vec2 yz = unpackUnorm2x16(binding_word(binding_at, 1u));
    vec3 bary = vec3(1.0 - yz.x - yz.y, yz);
    vec3 p = vec3(0.0), n = vec3(0.0);
    for (int k = 0; k < 3; k++) {
        uint vertex = o.info.w + texelFetch(index_stream, first + k).r;
        p += bary[k] * deformed_position(vertex);
        n += bary[k] * deformed_normal(vertex);
    }
    return pose_rigid(o, p, n);
}

// binding_at: the voxel's place among bindings, of deforming objects; p, n: in model space
posed voxel_pose(kd_voxel_object_params o, uint binding_at, vec3 p, vec3 n)
{
    return o.info.x == KD_VOXEL_RIGID ? pose_rigid(o, p, n)
         : o.info.x == KD_VOXEL_SKINNED ? pose_skinned(o.info.y, binding_at, p, n) : pose_attached(o, binding_at);
}
