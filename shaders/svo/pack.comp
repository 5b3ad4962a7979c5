// Sums of a layer to cell attributes of 16 bytes, one invocation a cell:
// albedo 3 x 10 bits | normal 3 x snorm8, share of double-sided voxels unorm8 | emission rgb9e5-like (see below) | weight, of 256
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/cell_attributes.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: counter, y: capacity
layout(std430, binding = 0) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer sums_block { uint sums[]; };
layout(std430, binding = 2) writeonly buffer attributes_block { uvec4 attributes[]; };

void main()
{
    uint cell = gl_GlobalInvocationID.x;
    if (cell >= min(counters[pass.x], pass.y))
        return;
    uint at = cell * KD_SUM_WORDS;
    uint weight = max(sums[at], 1u);
    float inverse = 1.0 / float(weight);
    cell_attributes a;
    a.albedo = vec3(sums[at + 1u], sums[at + 2u], sums[at + 3u]) * (inverse / 1023.0);
    a.normal = vec3(int(sums[at + 4u]), int(sums[at + 5u]), int(sums[at + 6u])) * (inverse / 127.0);
    // A lamp that shares its cell with the ceiling shines as brightly as one that does not.
    a.emission = vec3(sums[at + 7u], sums[at + 8u], sums[at + 9u]) * (256.0 / (KD_EMISSION_ONE * float(max(sums[at + 11u], 256u))));
    a.double_sided = float(sums[at + 10u]) * inverse;
    a.weight = sums[at];
    attributes[cell] = cell_attributes_pack(a);
}
