/* Morphs and skins the vertices of deforming instances: rest pose + weighted deltas, then linear blend
 * skinning into world space. Normals go by the cofactors of the blended matrix, so that uneven scale bends
 * them rightly. The same arithmetic, in the same order, as systems/deform/deform_reference.c. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "shaders/shared/deform.h"

layout(local_size_x = 64) in; /* KD_DEFORM_GROUP */

layout(std140, binding = KD_BIND_PASS) uniform params_block { kd_deform_params params; };
layout(std430, binding = KD_DEFORM_GEOMETRY) buffer geometry_block { uint geometry[]; };
layout(std430, binding = KD_DEFORM_SKINS) readonly buffer skins_block { uint skins[]; };
layout(std430, binding = KD_DEFORM_MORPHS) readonly buffer morphs_block { float morphs[]; };
layout(std430, binding = KD_DEFORM_JOINTS) readonly buffer joints_block { vec4 joints[]; };
layout(std430, binding = KD_DEFORM_ITEMS) readonly buffer items_block { kd_deform_item items[]; };
layout(std430, binding = KD_DEFORM_WORDS) readonly buffer words_block { uint words[]; };

struct vertex {
    vec3 position;
    vec3 normal;
    vec4 tangent;
};

vertex load(uint index)
{
    uint at = index * KD_GEOMETRY_WORDS;
    vertex v;
    v.position = uintBitsToFloat(uvec3(geometry[at], geometry[at + 1u], geometry[at + 2u]));
    v.normal = vec3(unpackSnorm2x16(geometry[at + 3u]), unpackSnorm2x16(geometry[at + 4u]).x);
    v.tangent = vec4(unpackSnorm2x16(geometry[at + 5u]), unpackSnorm2x16(geometry[at + 6u]));
    return v;
}

void store(uint index, vertex v)
{
    uint at = index * KD_GEOMETRY_WORDS;
    geometry[at] = floatBitsToUint(v.position.x);
    geometry[at + 1u] = floatBitsToUint(v.position.y);
    geometry[at + 2u] = floatBitsToUint(v.position.z);
    geometry[at + 3u] = packSnorm2x16(v.normal.xy);
    geometry[at + 4u] = packSnorm2x16(vec2(v.normal.z, 0.0));
    geometry[at + 5u] = packSnorm2x16(v.tangent.xy);
    geometry[at + 6u] = packSnorm2x16(v.tangent.zw);
    geometry[at + 7u] = 0u;
}

/* Scaled by the largest component first: cofactors of a small model would vanish when squared. */
vec3 unit(vec3 v, vec3 fallback)
{
    float largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    return largest > 1e-30 ? normalize(v / largest) : fallback;
}

void morph(kd_deform_item item, uint local, inout vertex v)
{
    vec3 normal = v.normal;
    for (uint i = 0u; i < item.morph.z; i++) {
        uint target = words[item.morph.y + 2u * i];
        float weight = uintBitsToFloat(words[item.morph.y + 2u * i + 1u]);
        uint at = (item.morph.x + target * item.range.z + local) * KD_MORPH_WORDS;
        v.position += weight * vec3(morphs[at], morphs[at + 1u], morphs[at + 2u]);
        normal += weight * vec3(morphs[at + 3u], morphs[at + 4u], morphs[at + 5u]);
    }
    v.normal = unit(normal, v.normal);
}

void skin(kd_deform_item item, uint local, inout vertex v)
{
    uint at = (item.range.w + local) * KD_SKIN_WORDS;
    uvec4 joint = uvec4(skins[at] & 0xffffu, skins[at] >> 16, skins[at + 1u] & 0xffffu, skins[at + 1u] >> 16);
    vec4 weight = vec4(unpackUnorm2x16(skins[at + 2u]), unpackUnorm2x16(skins[at + 3u]));
    vec4 rows[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
    for (int k = 0; k < 4; k++) {
        uint first = 3u * (item.skin.x + min(joint[k], item.skin.y - 1u));
        for (int r = 0; r < 3; r++)
            rows[r] += weight[k] * joints[first + uint(r)];
    }
    vec4 p = vec4(v.position, 1.0);
    vec3 x = rows[0].xyz, y = rows[1].xyz, z = rows[2].xyz;
    vec3 cx = cross(y, z), cy = cross(z, x), cz = cross(x, y);
    float side = dot(x, cx) < 0.0 ? -1.0 : 1.0;
    v.position = vec3(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
    v.normal = unit(side * vec3(dot(cx, v.normal), dot(cy, v.normal), dot(cz, v.normal)), v.normal);
    vec3 t = v.tangent.xyz;
    v.tangent.xyz = unit(vec3(dot(x, t), dot(y, t), dot(z, t)), t);
}

void main()
{
    uint group = gl_WorkGroupID.y * KD_DEFORM_ROW + gl_WorkGroupID.x;
    if (group >= params.count.x)
        return;
    kd_deform_item item = items[words[2u * group]];
    uint local = words[2u * group + 1u] + gl_LocalInvocationID.x;
    if (local >= item.range.z)
        return;
    vertex v = load(item.range.x + local);
    if (item.morph.z > 0u)
        morph(item, local, v);
    if (item.range.w != KD_DEFORM_NONE)
        skin(item, local, v);
    store(item.range.y + local, v);
}
