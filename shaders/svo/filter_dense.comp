// Filter, dense cells with something in them: six directions from the eight children, into the atlas of dense levels.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 below; }; // x: counter, y: capacity, z: first list entry; below: as in filter_sparse
layout(std430, binding = 0) readonly buffer counters_block { uint counters[]; };
layout(std430, binding = 1) readonly buffer list_block { uint list[]; };
layout(binding = 0, rgba16f) writeonly uniform image3D atlas;

#include "shaders/svo/filter_children.glsl"
#include "shaders/include/morton.glsl"

void main()
{
    uint node = gl_GlobalInvocationID.x;
    if (node >= min(counters[pass.x], pass.y))
        return;
    if (below.x != 0u)
        load_leaves(node);
    else
        load_nodes(node, below.y, below.z);
    uint code = list[pass.z + node], cascade = code >> (3 * KD_DENSE_LOG2);
    ivec3 cell = ivec3(morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u))) + ivec3(0, 0, int(cascade) * KD_DENSE);
    for (uint axis = 0u; axis < 3u; axis++) {
        imageStore(atlas, cell + ivec3(int(2u * axis) * KD_DENSE, 0, 0), along(axis, false));
        imageStore(atlas, cell + ivec3(int(2u * axis + 1u) * KD_DENSE, 0, 0), along(axis, true));
    }
}
