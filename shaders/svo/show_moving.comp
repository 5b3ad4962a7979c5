// The same for parents in which something moves, or did in the frame before: their leaves lie by this frame's ranks. One
// invocation four words of leaf parents; most have nothing to do.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/svo/show.glsl"

layout(binding = 2) uniform usamplerBuffer before; // rgba32ui: the words of `moved`
layout(std430, binding = 1) readonly buffer moved_cells_block { uint moved_cells[]; }; // which cells there were, by last frame's ranks
layout(std430, binding = 5) readonly buffer cells_block { uvec4 cells[]; };            // behind those of all parents, which there are
layout(std430, binding = 6) buffer moved_block { uint moved[]; }; // from pass.z on: parents with dynamic cells, here from the frame before

uvec4 parents_now(uint n)
{
    return pass.y != 0u ? uvec4(parents[n * 4u], parents[n * 4u + 1u], parents[n * 4u + 2u], parents[n * 4u + 3u]) : uvec4(0u);
}

// Cells that a parent had, or has, from the word that leads to its leaves. still: static ones
uint cells_before(uint block, uint still)
{
    uint rank = ((block & KD_BLOCK_FIRST) - places.blocks.w) >> 3;
    return !leads_to_moving(block) ? block >> KD_BLOCK_BITS : rank < pass.w ? still | moved_cells[rank] : KD_EMPTY;
}

uint cells_now(uint block, uint still)
{
    uint rank = ((block & KD_BLOCK_FIRST) - places.blocks.w) >> 3;
    return leads_to_moving(block) ? still | cells[8u * pass.y + (rank >> 2)][rank & 3u] : block >> KD_BLOCK_BITS;
}

void show_moved(uint number, uint code, uint above)
{
    uint place = block_place(above, code), was = nodes[place], still = book[places.blocks.x + number] >> KD_BLOCK_BITS;
    show(number, code, above);
    if (cells_before(was, still) != cells_now(nodes[place], still))
        book_tell_change(code >> (3u * pass.x));
}

void main()
{
    uint n = linear_index(), level = pass.x;
    if (n * 4u >= pass.z)
        return;
    uvec4 moves = parents_now(n), did = texelFetch(before, int(pass.z / 4u + n));
    for (uint k = 0u; k < 4u; k++) {
        uint word = n * 4u + k;
        for (uint bits = moves[k] | did[k]; bits != 0u; bits &= bits - 1u) {
            uint code = word * 32u + uint(findLSB(bits)), above = level == 0u ? 0u : find_node(level - 1u, code >> 3);
            uint number = level == 0u ? index[dense_place(code)] : above == KD_EMPTY ? KD_EMPTY : nodes[child_place(level, above, code)];
            if (number != KD_EMPTY)
                show_moved(number, code, above);
        }
        if (moves[k] != did[k])
            moved[pass.z + word] = moves[k];
    }
}
