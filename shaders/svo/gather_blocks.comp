// All blocks are moved together, into other buffers (systems/svo/blocks.c): first each is given its place there, then what
// belongs to leaves is copied, then words lead to the new places. One invocation a leaf parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_find.glsl"
#include "shaders/include/svo_blocks.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: step, z: words of a leaf that are copied, w: slots there
layout(std430, binding = 1) readonly buffer from_block { uint from[]; };
layout(std430, binding = 2) writeonly buffer to_block { uint to[]; };
layout(std430, binding = 5) buffer moved_block { uint moved[]; }; // words of the blocks' new places, by number

void main()
{
    uint number = linear_index();
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x) || book[places.codes[pass.x] + number] == KD_EMPTY)
        return;
    uint block = book[places.blocks.x + number], n = (block & KD_BLOCK_FIRST) == KD_BLOCK_WAITS ? 0u : block_slots(block);
    if (pass.y == 0u) {
        uint first = n == 0u ? 0u : atomicAdd(counters[KD_COUNT_TOP], n);
        // What finds no room there is left out.
        moved[number] = n == 0u ? block : first + n <= pass.w ? (block & ~KD_BLOCK_FIRST) | first : 0u;
        if (n != 0u && moved[number] == 0u)
            block_count_cells(book[places.codes[pass.x] + number], 0u, block_count(block));
    } else if (pass.y == 1u) {
        n = moved[number] == 0u ? 0u : n;
        uint first = (block & KD_BLOCK_FIRST) * pass.z, there = (moved[number] & KD_BLOCK_FIRST) * pass.z;
        for (uint i = 0u; i < n * pass.z; i++)
            to[there + i] = from[first + i];
    } else {
        book[places.blocks.x + number] = moved[number];
        nodes[find_block_place(pass.x, book[places.codes[pass.x] + number])] = moved[number];
    }
}
