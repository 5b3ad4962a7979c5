// Lists the numbers of the touched leaf parents, in the order of their codes.
layout(local_size_x = 64) in;

#include "shaders/include/svo_find.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words, y: level of the leaf parents
layout(std430, binding = 1) readonly buffer touched_block { uint touched[]; };
layout(std430, binding = 2) readonly buffer ranks_block { uint ranks[]; };

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint rank = ranks[word];
    for (uint bits = touched[word]; bits != 0u && rank < places.size.x; bits &= bits - 1u, rank++)
        book[places.others.w + rank] = find_node(pass.y, word * 32u + uint(findLSB(bits)));
}
