// Empties the dense cells that were occupied in the frame before and are not now.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/morton.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: counter of the frame before, y: capacity, z: first list entry
layout(std430, binding = 0) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer list_block { uint list[]; };
layout(std430, binding = 2) readonly buffer masks_block { uint masks[]; }; // of the dense level
layout(binding = 0, rgba16f) writeonly uniform image3D atlas;

void main()
{
    uint node = gl_GlobalInvocationID.x;
    if (node >= min(counters[pass.x], pass.y))
        return;
    uint code = list[pass.z + node];
    if ((masks[code >> 5] >> (code & 31u) & 1u) != 0u)
        return;
    ivec3 cell = ivec3(morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u))) + ivec3(0, 0, int(code >> (3 * KD_DENSE_LOG2)) * KD_DENSE);
    for (int k = 0; k < 6; k++)
        imageStore(atlas, cell + ivec3(k * KD_DENSE, 0, 0), vec4(0.0));
}
