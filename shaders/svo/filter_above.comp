// Filter, levels above the outermost cascade, one after the other: 32 cells an edge from its 64, then 16 …
// Of the first two, cells on the lists alone.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level above, from 1

#include "shaders/svo/filter_up.glsl"

ivec3 low; // of the eight, from the low corner

atlas_cell source_place(ivec3 offset)
{
    uint outer = places.size.w - 1u;
    if (pass.x == 1u)
        return atlas_place(outer, ivec3(dense_wrap(outer, low + offset)));
    return atlas_place_above(places.size.w, pass.x - 1u, low + offset);
}

void main()
{
    uint code = linear_index(), edge = uint(KD_DENSE) >> pass.x;
    if (code >= (pass.x <= 2u ? counters[KD_COUNT_ABOVE + pass.x - 1u] : edge * edge * edge))
        return;
    if (pass.x <= 2u)
        code = book[(pass.x == 1u ? places.above.y : places.above.z) + code];
    ivec3 cell = ivec3(morton_decode(code));
    low = cell * 2;
    put_mean_of_eight(atlas_place_above(places.size.w, pass.x, cell));
}
