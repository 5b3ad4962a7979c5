// The same for parents in which something moved in the frame before and nothing does any more, and for all in which something moves
// where there is no room for some; else these are shown when their cells are made (cells.comp). One invocation
// four words of leaf parents; most have nothing to do.
layout(local_size_x = 64) in;

#define KD_MOVED_BINDING 1
#include "shaders/include/linear.glsl"
#include "shaders/svo/show.glsl"

layout(binding = 0) uniform usamplerBuffer now;    // rgba32ui: the words of `parents`
layout(binding = 2) uniform usamplerBuffer before; // rgba32ui: the words of `moved`
layout(binding = 1) uniform usamplerBuffer still_parents; // rgba32ui: words of parents with static cells
layout(std140, binding = 1) uniform short_block { uvec4 short_of; }; // x: 1 when not all that moves is chained
layout(std430, binding = 5) readonly buffer cells_block { uvec4 cells[]; };            // behind those of all parents, which there are
layout(std430, binding = 6) buffer moved_block { uint moved[]; }; // parents with dynamic cells, here from the frame before

uvec4 parents_now(uint n) { return pass.y != 0u ? texelFetch(now, int(n)) : uvec4(0u); }

// Cells that a parent has, from the word that leads to its leaves. still: static ones
uint cells_now(uint block, uint still)
{
    uint rank = ((block & KD_BLOCK_FIRST) - places.blocks.w) >> 3;
    return leads_to_moving(block) ? still | cells[8u * pass.y + (rank >> 2)][rank & 3u] : block >> KD_BLOCK_BITS;
}

void show_moved(uint number, uint code, uint above)
{
    uint place = block_place(above, code), was = nodes[place], still = book[places.blocks.x + number] >> KD_BLOCK_BITS;
    show(number, code, above);
    if (cells_before(was, still, pass.w) != cells_now(nodes[place], still))
        book_tell_change(code >> (3u * pass.x));
}

void main()
{
    uint n = linear_index(), level = pass.x;
    if (n * 4u >= pass.z)
        return;
    uvec4 moves = parents_now(n), did = texelFetch(before, int(n));
    uvec4 left = did & ~moves & texelFetch(still_parents, int(n));
    uvec4 away = counters[KD_COUNT_PARENTS] > pass.y || short_of.x != 0u ? moves : uvec4(0u);
    uvec4 any_of = left | away | (moves ^ did);
    uint work = uint(any_of.x != 0u) | uint(any_of.y != 0u) << 1 | uint(any_of.z != 0u) << 2 | uint(any_of.w != 0u) << 3;
    for (; work != 0u; work &= work - 1u) {
        uint k = uint(findLSB(work)), word = n * 4u + k;
        for (uint bits = left[k] | away[k]; bits != 0u; bits &= bits - 1u) {
            uint code = word * 32u + uint(findLSB(bits)), above = level == 0u ? 0u : find_node(level - 1u, code >> 3);
            uint number = level == 0u ? index[dense_place(code)] : above == KD_EMPTY ? KD_EMPTY : nodes[child_place(level, above, code)];
            if (number != KD_EMPTY)
                show_moved(number, code, above);
        }
        if (moves[k] != did[k])
            moved[word] = moves[k];
    }
}
