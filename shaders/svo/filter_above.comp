// Filter, levels above the outermost cascade, one after the other: 32 cells an edge from its 64, then 16 …
// Of the first, cells on the list alone.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level above, from 1

#include "shaders/svo/filter_up.glsl"

ivec3 low; // of the eight, from the low corner

ivec3 source_place(ivec3 offset, int direction)
{
    uint outer = places.size.w - 1u;
    return pass.x == 1u ? atlas_place(outer, ivec3(dense_wrap(outer, low + offset)), direction)
                        : atlas_place_above(places.size.w, pass.x - 1u, low + offset, direction);
}

void main()
{
    uint code = linear_index(), edge = uint(KD_DENSE) >> pass.x;
    if (code >= (pass.x == 1u ? counters[KD_COUNT_ABOVE] : edge * edge * edge))
        return;
    if (pass.x == 1u)
        code = book[places.words.z + code];
    ivec3 cell = ivec3(morton_decode(code));
    low = cell * 2;
    for (int axis = 0; axis < 3; axis++) {
        imageStore(atlas, atlas_place_above(places.size.w, pass.x, cell, 2 * axis), along(axis, false));
        imageStore(atlas, atlas_place_above(places.size.w, pass.x, cell, 2 * axis + 1), along(axis, true));
    }
}
