// Gives the nodes of a level new numbers, the ranks of their codes, so that they fit less room. Levels are done from below: the
// words that lead to a level are changed when it is done, and carried along with their nodes when the level above is.
// One invocation a word of the level's mask.
layout(local_size_x = 64) in;

#include "shaders/include/svo_find.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words, y: first of the mask, z: level, w: where the new codes begin
layout(std430, binding = 1) readonly buffer masks_block { uint masks[]; };
layout(std430, binding = 2) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 5) writeonly buffer moved_block { uint moved_from[]; }; // new number to old

uint lead_to(uint code, uint number)
{
    uint was;
    if (pass.z == 0u) {
        uint place = dense_place(code);
        was = index[place];
        index[place] = number;
    } else {
        uint place = child_place(pass.z, find_node(pass.z - 1u, code >> 3), code);
        was = nodes[place];
        nodes[place] = number;
    }
    return was;
}

void main()
{
    uint word = linear_index();
    if (word >= pass.x)
        return;
    uint number = ranks[word];
    for (uint bits = masks[pass.y + word]; bits != 0u; bits &= bits - 1u, number++) {
        uint code = word * 32u + uint(findLSB(bits));
        moved_from[number] = lead_to(code, number);
        book[pass.w + number] = code;
    }
}
