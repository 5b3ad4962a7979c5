// Lists the numbers of the touched leaf parents; one invocation a word in which there are some.
layout(local_size_x = 64) in;

#include "shaders/include/svo_find.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // y: level of the leaf parents
layout(std430, binding = 1) readonly buffer touched_block { uint touched[]; };

void main()
{
    uint n = linear_index();
    if (n >= counters[KD_COUNT_TOUCHED_PARTS])
        return;
    uint word = book[places.words.w + n], bits = touched[word];
    uint at = atomicAdd(counters[KD_COUNT_TOUCHED], uint(bitCount(bits)));
    for (; bits != 0u && at < places.size.x; bits &= bits - 1u, at++)
        book[places.others.w + at] = find_node(pass.y, word * 32u + uint(findLSB(bits)));
}
