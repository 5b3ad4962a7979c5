// Nodes of a level that go, or that come, in the words of its mask that are not what they were. One invocation a block of 32
// words: it leaves the block's sum, and lists the words with their ranks inside the block. A node that comes needs its
// parent: where there was no number left for that one, it stays away too.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 at; }; // x: blocks, y: first word, z: 1 for what comes, w: first word of the parents or KD_EMPTY; at.x: bits of the words, y: room on the list
layout(std430, binding = 3) buffer now_block { uint now[]; };
layout(std430, binding = 1) readonly buffer before_block { uint before[]; };
layout(std430, binding = 2) readonly buffer diff_block { uint diff[]; };      // of every level, bits of the words that changed
layout(std430, binding = 4) writeonly buffer work_block { uvec2 work[]; };      // words in which nodes go or come; nodes before them in their block
layout(std430, binding = 5) writeonly buffer sums_block { uint sums[]; };

// Eight children of each of four parents.
uint children_of(uint word)
{
    uint four = now[pass.w + (word >> 3)] >> (4u * (word & 7u));
    return ((four & 1u) | (four & 2u) << 7 | (four & 4u) << 14 | (four & 8u) << 21) * 255u;
}

// Returns the bits of the nodes.
uint go_or_come(uint word)
{
    uint here = now[pass.y + word], was = before[pass.y + word];
    if (pass.z == 0u)
        return was & ~here;
    uint may = pass.w == KD_EMPTY ? KD_EMPTY : children_of(word);
    if ((here & ~may) != 0u)
        now[pass.y + word] = here & may;
    return here & may & ~was;
}

void main()
{
    uint block = gl_GlobalInvocationID.x, sum = 0u;
    if (block >= pass.x)
        return;
    for (uint words = diff[at.x + block]; words != 0u; words &= words - 1u) {
        uint word = block * 32u + uint(findLSB(words)), bits = go_or_come(word);
        for (uint n; bits != 0u; bits = 0u) {
            n = atomicAdd(counters[KD_COUNT_PARTS], 1u);
            if (n < at.y) {
                work[n] = uvec2(word, sum);
                sum += uint(bitCount(bits));
            } else { // more than was thought: those that come stay away
                now[pass.y + word] &= ~bits;
                counters[KD_COUNT_AWAY] = 1u;
            }
        }
    }
    sums[block] = sum;
}
