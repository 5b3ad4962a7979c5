// The change mask: leaf cells whose occupancy differs from the frame before. One invocation a word.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words of a layer's mask, y: 1 when something moves
layout(std430, binding = 3) readonly buffer moving_block { uint moving[]; }; // of the dynamic one
layout(std430, binding = 2) buffer changes_block { uint changes[]; };      // occupied before, then by what stands still

void main()
{
    uint word = linear_index();
    if (word >= pass.x)
        return;
    uint now = changes[pass.x + word] | (pass.y != 0u ? moving[word] : 0u);
    changes[word] ^= now;
    changes[pass.x + word] = now;
}
