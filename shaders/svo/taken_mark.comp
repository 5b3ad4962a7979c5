// Build `levels`, first half of a level: every voxel marks, in the nodes of the level above, the children that its cells need.
// Source: Yalciner 2016, section 4.5, level by level reconstruction.
layout(local_size_x = 128) in;

#include "shaders/include/splat.glsl"
#include "shaders/svo/taken.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level; that of the leaves marks cells
layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) readonly buffer voxels_block { uint voxels[]; };

void mark(uint code)
{
    uint level = pass.x, levels = places.size.y, at = code >> (3u * (levels - level));
    uint parent = level == 0u ? 0u : find_node(level - 1u, at >> 3);
    if (parent == KD_EMPTY)
        return;
    if (level == 0u)
        index[dense_place(at)] = KD_MARKED;
    else if (level < levels)
        nodes[child_place(level, parent, at)] = KD_MARKED;
    else
        leaf_words[taken_leaf_place(parent, at)] = KD_MARKED;
}

void main()
{
    uint slot = gl_WorkGroupID.y, i = gl_GlobalInvocationID.x;
    kd_voxel_segment segment = segments[slot];
    if (i >= segment.count)
        return;
    uint from = (slot * KD_SEGMENT_VOXELS + i) * KD_PAGE_WORDS, cell_word = voxels[from];
    if (cell_word == KD_NO_VOXEL)
        return;
    splat s = splat_unpack(cell_word, voxels[from + 1u]);
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c);
    for (uint corners = splat_corners(s, c); corners != 0u; corners &= corners - 1u)
        mark(first + morton_encode(cell_wrap(c, splat_cell(s, uint(findLSB(corners))))));
}
