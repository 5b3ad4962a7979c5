// After a level's nodes have taken their numbers: the bits of its mask, how many lie in each cascade, and all of them to be
// filtered. One invocation a number.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/svo_book.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level
layout(std430, binding = 1) buffer masks_block { uint masks[]; };

shared uint in_cascade[KD_MAX_CASCADES];

void list(uint level, uint number, uint count)
{
    uint code = book[places.codes[level] + number];
    atomicOr(masks[places.masks[level] + (code >> 5)], 1u << (code & 31u));
    atomicAdd(in_cascade[code >> (3u * (KD_DENSE_LOG2 + level))], 1u);
    if (level == 0u) {
        book_change_dense(code);
        return;
    }
    if ((number & 31u) == 0u)
        book[places.changed[level] + (number >> 5)] = count - number < 32u ? (1u << (count - number)) - 1u : KD_EMPTY;
}

void main()
{
    uint number = linear_index(), level = pass.x, count = min(counters[KD_COUNT_NEED + level], places.room[level]);
    uint local = gl_LocalInvocationIndex;
    if (local < KD_MAX_CASCADES)
        in_cascade[local] = 0u;
    barrier();
    if (number < count)
        list(level, number, count);
    barrier();
    if (local < places.size.w && in_cascade[local] != 0u)
        atomicAdd(counters[KD_COUNT_NODES + 4u * level + local], in_cascade[local]);
}
