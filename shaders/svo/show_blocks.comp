// Shows the leaves of touched parents (show.glsl), but for those that show_moving.comp does. One invocation a touched parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/svo/show.glsl"

layout(std430, binding = 1) readonly buffer touched_block { uint touched[]; }; // numbers

void main()
{
    uint entry = linear_index(), level = pass.x;
    if (entry >= min(counters[KD_COUNT_TOUCHED], places.size.x))
        return;
    uint number = touched[entry];
    if (number == KD_EMPTY)
        return;
    uint code = book[places.codes[level] + number];
    uint above = level == 0u ? 0u : find_node(level - 1u, code >> 3);
    if (!leads_to_moving(nodes[block_place(above, code)]) && !leads_to_moving(seen_block(number, code)))
        show(number, code, above);
}
