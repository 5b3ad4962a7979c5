// Lists the nodes of a sparse level that are to be filtered. One invocation a word of their bits.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level, y: first word, z: words of this round
layout(std430, binding = 1) writeonly buffer work_block { uint work[]; };

void main()
{
    uint level = pass.x, word = pass.y + linear_index();
    if (linear_index() >= pass.z)
        return;
    uint bits = book[places.changed[level] + word];
    uint at = bits != 0u ? atomicAdd(counters[KD_COUNT_CHANGED + level], uint(bitCount(bits))) : 0u;
    for (; bits != 0u; bits &= bits - 1u)
        work[at++] = word * 32u + uint(findLSB(bits));
}
