// Ranks of set bits, pass 1 of 3: population count of every block of 32 words.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: first mask word, y: words, z: first rank word, w: counter
layout(std430, binding = 0) readonly buffer mask_block { uint mask[]; };
layout(std430, binding = 1) writeonly buffer sums_block { uint sums[]; };

void main()
{
    uint block = linear_index();
    uint begin = block * 32u;
    if (begin >= pass.y)
        return;
    uint end = min(begin + 32u, pass.y);
    uint sum = 0u;
    for (uint i = begin; i < end; i++)
        sum += uint(bitCount(mask[pass.x + i]));
    sums[block] = sum;
}
