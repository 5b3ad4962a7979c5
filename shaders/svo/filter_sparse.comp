// Filter, sparse levels: a node's optical depth by direction and its mean radiance from its eight children. Radiance is the
// mean of what the six directions see, so a thin wall keeps the colours of both its sides in equal parts. What comes out as
// it was changes nothing above.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 below; }; // x: level, z: first data entry; below.x: 1 when children are leaves, y: first slot, z: first data entry

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_find.glsl"
#include "shaders/svo/filter_children.glsl"

void main()
{
    uint entry = linear_index(), level = pass.x;
    if (entry >= counters[KD_COUNT_CHANGED + level])
        return;
    uint number = work[entry], code = book[places.codes[level] + number];
    if (code == KD_EMPTY)
        return;
    uint parent = find_node(level - 1u, code >> 3);
    if (below.x != 0u)
        load_leaves(nodes[block_place(parent, code)]);
    else
        load_nodes(number, below.y, below.z);
    for (bool alone = stands_alone(level, code); alone; alone = false)
        spread_alone();
    node_value n;
    vec4 seen = vec4(0.0);
    vec4 forth[3], back[3];
    float shown = along_all(forth, back);
    for (int axis = 0; axis < 3; axis++) {
        n.depth[2 * axis] = forth[axis].a;
        n.depth[2 * axis + 1] = back[axis].a;
        seen += forth[axis] + back[axis];
    }
    n.radiance = seen.a > 0.0 ? shown * (seen.rgb / seen.a) : vec3(0.0);
    uvec2 word = node_pack(n);
    if (word == data[pass.z + number])
        return;
    data[pass.z + number] = word;
    change_above(level, code, parent);
}
