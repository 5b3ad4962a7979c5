// Nodes of a level that go, or that come. One that comes needs its parent: where there was no number left for that one, it
// stays away too. Words with such nodes are listed.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words, y: first word, z: 1 for what comes, w: first word of the parents or KD_EMPTY
layout(std430, binding = 3) buffer now_block { uint now[]; };
layout(std430, binding = 1) readonly buffer before_block { uint before[]; };
layout(std430, binding = 2) writeonly buffer diff_block { uint diff[]; };

// Eight children of each of four parents.
uint children_of(uint word)
{
    uint four = now[pass.w + (word >> 3)] >> (4u * (word & 7u));
    return ((four & 1u) | (four & 2u) << 7 | (four & 4u) << 14 | (four & 8u) << 21) * 255u;
}

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint here = now[pass.y + word], was = before[pass.y + word];
    uint may = pass.w == KD_EMPTY || pass.z == 0u ? KD_EMPTY : children_of(word);
    if ((here & ~may) != 0u)
        now[pass.y + word] = here & may;
    uint bits = pass.z == 0u ? was & ~here : here & may & ~was;
    diff[word] = bits;
    if (bits != 0u)
        book[places.words.x + atomicAdd(counters[KD_COUNT_PARTS], 1u)] = word;
}
