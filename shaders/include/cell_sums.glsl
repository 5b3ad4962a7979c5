// Attribute sums of cells: integers, weighted by coverage, so that they are the same in whatever order the threads come.
#ifndef KD_SUMS_BINDING
#define KD_SUMS_BINDING 7
#endif
#include "shaders/include/cell_shares.glsl"
#include "shaders/include/axis.glsl"

layout(std430, binding = KD_SUMS_BINDING) buffer sums_block { uint sums[]; };

struct voxel_share {
    uvec3 albedo;   // linear, 10 bits
    ivec3 normal;   // snorm8
    uvec3 emission; // KD_EMISSION_ONE is the brightest of the scene
    bool double_sided;
    uint area;      // of what glows
};

// color, share: words of the cached voxel; emissive: of its object, relative to the brightest
voxel_share voxel_share_of(uint color, uint share, uint normal, vec3 emissive)
{
    return voxel_share(share_albedo(color), snorm8_unpack(normal), share_emission(share, emissive),
                       share_double_sided(color) != 0u, share_area(color));
}

void sums_add(uint cell, uint weight, voxel_share v)
{
    uint at = cell * KD_SUM_WORDS;
    atomicAdd(sums[at], weight);
    atomicAdd(sums[at + 1u], v.albedo.x * weight);
    atomicAdd(sums[at + 2u], v.albedo.y * weight);
    atomicAdd(sums[at + 3u], v.albedo.z * weight);
    atomicAdd(sums[at + 4u], uint(v.normal.x * int(weight)));
    atomicAdd(sums[at + 5u], uint(v.normal.y * int(weight)));
    atomicAdd(sums[at + 6u], uint(v.normal.z * int(weight)));
    ivec3 axis = normal_axis(v.normal) * int(weight);
    atomicAdd(sums[at + 13u], uint(axis.x));
    atomicAdd(sums[at + 14u], uint(axis.y));
    atomicAdd(sums[at + 15u], uint(axis.z));
    // A loop, since software drivers run a branch that no voxel takes.
    for (bool glows = v.emission != uvec3(0u); glows; glows = false) {
        atomicAdd(sums[at + 7u], (v.emission.x * weight + 128u) >> 8);
        atomicAdd(sums[at + 8u], (v.emission.y * weight + 128u) >> 8);
        atomicAdd(sums[at + 9u], (v.emission.z * weight + 128u) >> 8);
        atomicAdd(sums[at + 11u], weight);
        atomicAdd(sums[at + 12u], v.area * weight);
    }
    if (v.double_sided)
        atomicAdd(sums[at + 10u], weight);
}
