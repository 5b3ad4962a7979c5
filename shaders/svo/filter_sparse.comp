// Filter, sparse levels: a node's optical depth by direction and its mean radiance from its eight children. Radiance is the
// mean of what the six directions see, so a thin wall keeps the colours of both its sides in equal parts.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 below; }; // x: counter, y: capacity, z: first data entry; below.x: 1 when children are leaves, y: first slot, z: first data entry
layout(std430, binding = 0) readonly buffer counters_block { uint counters[]; };

#include "shaders/svo/filter_children.glsl"

void main()
{
    uint node = gl_GlobalInvocationID.x;
    if (node >= min(counters[pass.x], pass.y))
        return;
    if (below.x != 0u)
        load_leaves(node);
    else
        load_nodes(node, below.y, below.z);
    node_value n;
    vec4 seen = vec4(0.0);
    for (uint axis = 0u; axis < 3u; axis++) {
        vec4 forth = along(axis, false), back = along(axis, true);
        n.depth[2u * axis] = forth.a;
        n.depth[2u * axis + 1u] = back.a;
        seen += forth + back;
    }
    n.radiance = seen.a > 0.0 ? seen.rgb / seen.a : vec3(0.0);
    data[pass.z + node] = node_pack(n);
}
