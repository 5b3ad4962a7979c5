// Carries what belongs to nodes to their new numbers: rows of words, one invocation a word.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words of a row, y: rows, z: first word there, w: first word here
layout(std430, binding = 1) readonly buffer from_block { uint from[]; };
layout(std430, binding = 2) writeonly buffer to_block { uint to[]; };
layout(std430, binding = 5) readonly buffer moved_block { uint moved_from[]; };

void main()
{
    uint n = linear_index(), row = n / pass.x, word = n % pass.x;
    if (row < pass.y)
        to[pass.w + n] = from[pass.z + moved_from[row] * pass.x + word];
}
