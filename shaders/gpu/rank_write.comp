// Ranks of set bits, pass 3 of 3: the rank of a word is the number of bits set before it.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first mask word, y: words, z: first rank word
layout(std430, binding = 0) readonly buffer mask_block { uint mask[]; };
layout(std430, binding = 1) readonly buffer sums_block { uint sums[]; };
layout(std430, binding = 3) writeonly buffer ranks_block { uint ranks[]; };

void main()
{
    uint block = linear_index();
    uint begin = block * 32u;
    if (begin >= pass.y)
        return;
    uint end = min(begin + 32u, pass.y);
    uint running = sums[block];
    for (uint i = begin; i < end; i++) {
        ranks[pass.z + i] = running;
        running += uint(bitCount(mask[pass.x + i]));
    }
}
