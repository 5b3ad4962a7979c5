// Filter, dense cells: six directions from the eight children, into the atlas of dense levels. A cell without a node any more
// is emptied.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 below; }; // below: as in filter_sparse

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_find.glsl"
#include "shaders/svo/filter_children.glsl"
#include "shaders/svo/filter_target.glsl"

void main()
{
    uint entry = linear_index();
    if (entry >= counters[KD_COUNT_CHANGED])
        return;
    uint code = work[entry], c = code >> (3 * KD_DENSE_LOG2);
    uint number = index[dense_place(code)];
    if (number == KD_EMPTY)
        load_nothing();
    else if (below.x != 0u)
        load_leaves(nodes[block_place(0u, code)]);
    else
        load_nodes(number, below.y, below.z);
    for (bool alone = stands_alone(0u, code); alone; alone = false)
        spread_alone();
    ivec3 cell = ivec3(morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u)));
    atlas_cell at = atlas_place(c, cell);
    vec4 forth[3], back[3];
    vec4 shown = vec4(vec3(along_all(forth, back)), 1.0);
    atlas_put(at, 0, shown * forth[0], shown * forth[1], shown * forth[2]);
    atlas_put(at, 1, shown * back[0], shown * back[1], shown * back[2]);
    note_filled(code, number != KD_EMPTY);
    change_coarser(c, cell);
}
