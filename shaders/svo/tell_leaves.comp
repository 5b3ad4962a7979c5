// With one layer: a sum over the leaves of each dense cell, which tells whether they are those of the frame before. One
// invocation a leaf parent.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"
#include "shaders/include/cell_load.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: parents with room for dynamic cells
layout(std430, binding = 6) buffer told_block { uint told[]; };

// Any two parents and sets of leaves in them should give numbers that have nothing to do with each other.
// Source: the finalizer of MurmurHash3 (Appleby).
uint hash(uint code, uint cells)
{
    uint h = (code ^ cells * 0x9E3779B9u) * 0x85EBCA6Bu;
    h = (h ^ (h >> 13)) * 0xC2B2AE35u;
    return h ^ (h >> 16);
}

void main()
{
    uint number = linear_index();
    if (number >= min(counters[KD_COUNT_HIGH], places.size.x))
        return;
    uint code = book[places.codes[pass.x] + number];
    if (code == KD_EMPTY)
        return;
    cell_parent p = cell_parent_of(number, code, pass.y);
    uint cells = p.block >> KD_BLOCK_BITS | p.moves;
    if (cells != 0u)
        atomicAdd(told[code >> (3u * pass.x)], hash(code, cells));
}
