// Filter, cascade to cascade: cells of the coarser one's central half from those of the finer one.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: cascade

#include "shaders/svo/filter_up.glsl"

ivec3 low; // of the eight, from the finer cascade's low corner

atlas_cell source_place(ivec3 offset)
{
    return atlas_place(pass.x - 1u, ivec3(dense_wrap(pass.x - 1u, low + offset)));
}

void main()
{
    uint entry = linear_index(), c = pass.x;
    if (entry >= counters[KD_COUNT_UP + c])
        return;
    uint code = book[places.others.z + c * KD_UP_CELLS + entry];
    ivec3 cell = ivec3(morton_decode(code));
    low = (dense_unwrap(c, uvec3(cell)) - KD_DENSE / 4) * 2;
    note_filled(c << (3 * KD_DENSE_LOG2) | code, put_mean_of_eight(atlas_place(c, cell)));
    change_coarser(c, cell);
}
