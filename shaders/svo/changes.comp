// The change mask: leaf cells whose occupancy differs from the frame before. One invocation four words; few have anything to
// write.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words of a layer's mask, y: 1 when something moves
layout(binding = 0) uniform usamplerBuffer moving; // rgba32ui: cells of the dynamic layer
layout(binding = 1) uniform usamplerBuffer still;  // rgba32ui: of the static one
layout(binding = 2) uniform usamplerBuffer before; // rgba32ui: the words of `changes`
layout(std430, binding = 2) writeonly buffer changes_block { uint changes[]; }; // changed, then occupied now

void main()
{
    uint n = linear_index();
    if (n * 4u >= pass.x)
        return;
    uvec4 now = texelFetch(still, int(n)) | (pass.y != 0u ? texelFetch(moving, int(n)) : uvec4(0u));
    uvec4 differs = now ^ texelFetch(before, int(pass.x / 4u + n)), writes = differs | texelFetch(before, int(n));
    uint work = uint(writes.x != 0u) | uint(writes.y != 0u) << 1 | uint(writes.z != 0u) << 2 | uint(writes.w != 0u) << 3;
    for (; work != 0u; work &= work - 1u) {
        uint k = uint(findLSB(work));
        changes[n * 4u + k] = differs[k];
        changes[pass.x + n * 4u + k] = now[k];
    }
}
