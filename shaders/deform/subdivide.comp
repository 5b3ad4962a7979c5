/* Limit points of subdivision surfaces from their posed cages: a row of weights for each vertex, and the normal from the
 * derivatives. Cages are posed before, so that a thousand limit points cost the skinning of some ten vertices. The same
 * sums in the same order as kd_subdivision_evaluate.
 * Source: Nießner, Loop, Meyer, DeRose 2012, section 4 (tables of stencils on the GPU) */

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "shaders/shared/deform.h"

layout(local_size_x = 64) in; /* KD_DEFORM_GROUP */

layout(std140, binding = KD_BIND_PASS) uniform params_block { kd_deform_params params; };
layout(std430, binding = KD_DEFORM_GEOMETRY) buffer geometry_block { uint geometry[]; };
layout(std430, binding = KD_SUBDIVIDE_ROWS) readonly buffer rows_block { kd_stencil_row_words rows[]; };
layout(std430, binding = KD_SUBDIVIDE_STENCILS) readonly buffer stencils_block { kd_stencil_words stencils[]; };
layout(std430, binding = KD_DEFORM_ITEMS) readonly buffer items_block { kd_subdivide_item items[]; };
layout(std430, binding = KD_DEFORM_WORDS) readonly buffer words_block { uint words[]; };

vec3 direction(vec3 v, vec3 fallback)
{
    float largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    return largest > 1e-30 ? normalize(v / largest) : fallback;
}

void main()
{
    uint group = gl_WorkGroupID.y * KD_DEFORM_ROW + gl_WorkGroupID.x;
    if (group >= params.count.x)
        return;
    kd_subdivide_item item = items[words[2u * group]];
    uint local = words[2u * group + 1u] + gl_LocalInvocationID.x;
    if (local >= item.range.z)
        return;
    kd_stencil_row_words row = rows[item.range.w + local];
    vec3 position = vec3(0.0), du = vec3(0.0), dv = vec3(0.0);
    for (uint i = row.first; i < row.first + row.count; i++) {
        kd_stencil_words s = stencils[i];
        uint at = (item.cage.x + s.vertex) * KD_GEOMETRY_WORDS;
        vec3 p = uintBitsToFloat(uvec3(geometry[at], geometry[at + 1u], geometry[at + 2u]));
        position += s.weight * p;
        du += s.du * p;
        dv += s.dv * p;
    }
    uint rest = (item.range.x + local) * KD_GEOMETRY_WORDS, to = (item.range.y + local) * KD_GEOMETRY_WORDS;
    vec3 rest_normal = vec3(unpackSnorm2x16(geometry[rest + 3u]), unpackSnorm2x16(geometry[rest + 4u]).x);
    vec4 rest_tangent = vec4(unpackSnorm2x16(geometry[rest + 5u]), unpackSnorm2x16(geometry[rest + 6u]));
    vec3 normal = direction(cross(direction(du, vec3(0.0)), direction(dv, vec3(0.0))), rest_normal);
    vec3 t = row.tangent_u * du + row.tangent_v * dv;
    vec3 tangent = direction(t - dot(t, normal) * normal, rest_tangent.xyz);
    geometry[to] = floatBitsToUint(position.x);
    geometry[to + 1u] = floatBitsToUint(position.y);
    geometry[to + 2u] = floatBitsToUint(position.z);
    geometry[to + 3u] = packSnorm2x16(normal.xy);
    geometry[to + 4u] = packSnorm2x16(vec2(normal.z, 0.0));
    geometry[to + 5u] = packSnorm2x16(tangent.xy);
    geometry[to + 6u] = packSnorm2x16(vec2(tangent.z, rest_tangent.w));
    geometry[to + 7u] = 0u;
}
