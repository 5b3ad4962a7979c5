// The eight children of a node, whatever they are: leaves, or sparse nodes reached through the node table (svo_find.glsl).

#include "shaders/include/tree_params.glsl"
#include "shaders/include/tree_node.glsl"
#include "shaders/include/leaf_block.glsl"

layout(std430, binding = 1) readonly buffer work_block { uint work[]; }; // what is to be filtered
layout(std430, binding = 2) readonly buffer leaves_block { uvec2 leaves[]; };
layout(std430, binding = 5) buffer data_block { uvec2 data[]; };

const node_value NOTHING = node_value(vec3(0.0), float[6](0.0, 0.0, 0.0, 0.0, 0.0, 0.0), float[6](0.0, 0.0, 0.0, 0.0, 0.0, 0.0));

node_value child[8];

// A node of a cascade that has given up the levels below it has one child, which stands for all eight.
bool stands_alone(uint level, uint code)
{
    return level + cascade_given_up(code >> (3u * (KD_DENSE_LOG2 + level))) >= places.size.y;
}

void spread_alone()
{
    for (uint i = 0u; i < 6u; i++)
        child[0].depth[i] *= 0.5; // of two in a row
    for (uint i = 1u; i < 8u; i++)
        child[i] = child[0];
}

void load_nothing()
{
    for (uint i = 0u; i < 8u; i++)
        child[i] = NOTHING;
}

void load_leaves(uint block)
{
    for (uint i = 0u; i < 8u; i++)
        child[i] = node_of_leaf(block_has(block, i) ? leaves[block_slot(block, i)] : uvec2(0u));
}

void load_nodes(uint node, uint first_slot, uint first_data)
{
    for (uint i = 0u; i < 8u; i++) {
        uint word = nodes[first_slot + node * 8u + i];
        if (word == KD_EMPTY)
            child[i] = NOTHING;
        else
            child[i] = node_unpack(data[first_data + word]);
    }
}

// What a ray along `axis` (0 x, 1 y, 2 z), backwards when `reverse`, sees of the eight: (tau S, tau).
vec4 along(uint axis, bool reverse)
{
    uint direction = 2u * axis + uint(reverse);
    uint step = 1u << axis, a = 1u << ((axis + 1u) % 3u), b = 1u << ((axis + 2u) % 3u);
    vec4 sum = vec4(0.0);
    float depths = 0.0;
    for (uint k = 0u; k < 4u; k++) {
        uint low = (k & 1u) * a + (k >> 1) * b;
        uint front = reverse ? low + step : low, back = reverse ? low : low + step;
        sum += behind(child[front].side[direction] * child[front].radiance, child[front].depth[direction],
                      child[back].side[direction] * child[back].radiance, child[back].depth[direction]);
        depths += child[front].depth[direction] + child[back].depth[direction];
    }
    return column_mean(sum, depths, tree_is_strict());
}

// The same of all three axes, both ways; returns the share of its light that the node may show.
float along_all(out vec4 forth[3], out vec4 back[3])
{
    for (uint axis = 0u; axis < 3u; axis++) {
        forth[axis] = along(axis, false);
        back[axis] = along(axis, true);
    }
    return tree_is_strict() ? light_of_one_side(vec3(forth[0].a, forth[1].a, forth[2].a), vec3(back[0].a, back[1].a, back[2].a)) : 1.0;
}
