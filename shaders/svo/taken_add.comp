// Adds the attributes of page voxels to their cells, down from the dense cell: for each cell that a voxel covers, through the
// sparse levels to its leaf.
//
// With KD_TAKE (build `atomic`) what is missing on the way is made: the first to come locks the word that should lead on,
// takes a number, prepares the node and opens the word; others look again. Nobody waits for long: after KD_TAKE_TRIES looks the
// cell is noted in the page voxel, and a further pass (pass.y = 1) does what was noted. Between passes no word is locked.
// Without it (build `levels`) the tree is there.
// Source: Yalciner 2016, section 4.5, full atomic reconstruction; Crassin and Green 2012 for the lock in the pointer.
layout(local_size_x = 128) in;

#ifdef KD_TAKE
#define KD_FIND_ACCESS coherent volatile
#endif
#define KD_SUMS_BINDING 6
#define KD_LOCKED 0xFFFFFFFEu
#define KD_TAKE_TRIES 64u

#include "shaders/include/linear.glsl"
#include "shaders/include/splat.glsl"
#include "shaders/svo/taken.glsl"
#include "shaders/include/cell_sums.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: cells that there is room for, y: 1 for what was noted, z: segment slots
layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) buffer voxels_block { uint voxels[]; };
layout(binding = 0) uniform samplerBuffer objects; // rgba32f, eight an object

#ifdef KD_TAKE
// What the word at `place` leads to: a number; KD_EMPTY when there was none left; KD_LOCKED when somebody else is still at it.
#define TAKE_FUNCTION(name, memory, take)                                                     \
    uint name(uint place, uint level, uint code)                                              \
    {                                                                                         \
        uint word = memory[place];                                                            \
        for (uint tries = 0u; tries < KD_TAKE_TRIES && word >= KD_LOCKED; tries++) {          \
            if (word == KD_EMPTY)                                                             \
                word = atomicCompSwap(memory[place], KD_EMPTY, KD_LOCKED);                    \
            else                                                                              \
                word = memory[place];                                                         \
            if (word == KD_EMPTY) {                                                           \
                word = take;                                                                  \
                memoryBarrierBuffer();                                                        \
                atomicExchange(memory[place], word);                                          \
                tries = KD_TAKE_TRIES;                                                        \
            }                                                                                 \
        }                                                                                     \
        return word;                                                                          \
    }

uint take_node(uint level, uint code)
{
    if (counters[KD_COUNT_NEED + level] > places.room[level])
        return KD_EMPTY;
    uint number = taken_number(level);
    if (number != KD_EMPTY)
        taken_open(level, number, code);
    return number;
}

TAKE_FUNCTION(take_dense, index, take_node(level, code))
TAKE_FUNCTION(take_child, nodes, take_node(level, code))
TAKE_FUNCTION(take_leaf, leaf_words, taken_cell(pass.x))
#else
uint take_dense(uint place, uint level, uint code) { return index[place]; }
uint take_child(uint place, uint level, uint code) { return nodes[place]; }
uint take_leaf(uint place, uint level, uint code) { return leaf_words[place]; }
#endif

// Number of a cell in the sums, or KD_EMPTY, or KD_LOCKED.
uint cell_of(uint code)
{
    uint levels = places.size.y, above = code >> (3u * levels);
    uint number = take_dense(dense_place(above), 0u, above);
    for (uint level = 1u; level < levels && number < KD_LOCKED; level++) {
        above = code >> (3u * (levels - level));
        number = take_child(child_place(level, number, above), level, above);
    }
    return number < KD_LOCKED ? take_leaf(taken_leaf_place(number, code), levels, code) : number;
}

void main()
{
    uint slot = linear_index() / KD_SEGMENT_VOXELS, i = linear_index() % KD_SEGMENT_VOXELS;
    if (slot >= pass.z)
        return;
    kd_voxel_segment segment = segments[slot];
    if (i >= segment.count)
        return;
    uint from = (slot * KD_SEGMENT_VOXELS + i) * KD_PAGE_WORDS;
    uint cell_word = voxels[from], fraction = voxels[from + 1u];
    if (cell_word == KD_NO_VOXEL || (pass.y != 0u && fraction >> 24 == 0u))
        return;
    splat s = splat_unpack(cell_word, fraction);
    uint normal = voxels[from + 2u];
    voxel_share v = voxel_share_of(voxels[from + 3u], normal >> 24, normal, texelFetch(objects, int(segment.object) * 8 + 7).rgb);
    uint c = segment.chunk_cascade >> 28, first = cascade_first_bit(c), left = 0u;
    for (uint corners = pass.y != 0u ? fraction >> 24 : splat_corners(s, c); corners != 0u; corners &= corners - 1u) {
        uint k = uint(findLSB(corners)), cell = cell_of(first + morton_encode(cell_wrap(c, splat_cell(s, k))));
        if (cell < KD_LOCKED)
            sums_add(cell, splat_weight(s, k), v);
        else if (cell == KD_LOCKED)
            left |= 1u << k;
    }
#ifdef KD_TAKE
    if (left != fraction >> 24)
        voxels[from + 1u] = (fraction & 0xFFFFFFu) | left << 24;
    if (left != 0u)
        counters[KD_COUNT_LEFT] = 1u;
#endif
}
