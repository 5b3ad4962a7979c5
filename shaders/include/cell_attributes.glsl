// What a cell of one layer holds, and how it comes out of 16 bytes; shaders/svo/pack.comp packs them.

#include "shaders/shared/voxel.h"
#include "shaders/include/octahedral.glsl"

struct cell_attributes {
    vec3 albedo;
    vec3 normal;        // length below 1 where surfaces of several directions meet
    vec3 emission;      // relative to the scene's brightest
    float double_sided; // share
    bool thin;          // surfaces of opposite sides, or double-sided ones: `normal` is a unit axis
    uint weight;        // coverage, 256 a whole voxel or more of them
    float area;         // that glows with this emission, in faces of a cell
};

cell_attributes cell_attributes_unpack(uvec4 w)
{
    cell_attributes a;
    a.albedo = vec3(w.x & 1023u, (w.x >> 10) & 1023u, (w.x >> 20) & 1023u) / 1023.0;
    a.thin = w.y >> 31 != 0u;
    a.normal = a.thin ? octahedral_unpack(w.y) : unpackSnorm4x8(w.y).xyz;
    a.double_sided = float(w.x >> 30) / 3.0;
    a.emission = vec3(w.z & 511u, (w.z >> 9) & 511u, (w.z >> 18) & 511u) * (exp2(-float(w.z >> 27)) / 511.0);
    a.weight = ((w.y >> 24 & 127u) * 512u + 127u) / 254u;
    a.area = float(w.w) / (256.0 * KD_AREA_ONE);
    return a;
}

// Two layers in one cell: the mean by coverage.
cell_attributes cell_attributes_merge(cell_attributes a, cell_attributes b)
{
    float wa = float(a.weight), wb = float(b.weight), inverse = 1.0 / max(wa + wb, 1.0);
    a.albedo = (a.albedo * wa + b.albedo * wb) * inverse;
    if (a.thin || b.thin) {
        a.normal = wa >= wb ? a.normal : b.normal;
        a.thin = wa >= wb ? a.thin : b.thin;
    } else {
        a.normal = (a.normal * wa + b.normal * wb) * inverse;
    }
    // Emission adds up: what lies on a lamp does not dim it (as in svo/pack.comp).
    vec3 shining = (a.emission * min(wa, 256.0) + b.emission * min(wb, 256.0)) / clamp(wa + wb, 1.0, 256.0);
    vec3 powers = a.emission * a.area + b.emission * b.area;
    a.emission = min(shining, max(a.emission, b.emission));
    a.area = dot(powers, vec3(1.0)) / max(dot(a.emission, vec3(1.0)), 1e-9);
    a.double_sided = (a.double_sided * wa + b.double_sided * wb) * inverse;
    a.weight += b.weight;
    return a;
}
