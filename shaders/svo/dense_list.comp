// Lists the dense cells that are to be filtered: those that have nodes or held something. Cells of a coarser cascade that the
// finer one fills go to that cascade's list.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/morton.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words
layout(std430, binding = 1) writeonly buffer work_block { uint work[]; };
layout(std430, binding = 2) readonly buffer masks_block { uint masks[]; };

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint bits = book[places.changed.x + word] & (masks[places.masks.x + word] | book[places.others.x + word]);
    for (; bits != 0u; bits &= bits - 1u) {
        uint code = word * 32u + uint(findLSB(bits)), c = code >> (3 * KD_DENSE_LOG2), cell_code = code & ((1u << (3 * KD_DENSE_LOG2)) - 1u);
        ivec3 cell = dense_unwrap(c, morton_decode(cell_code));
        if (in_finer_cascade(c, cell << int(tree.info.w)))
            book_change_up(c, cell_code);
        else
            work[atomicAdd(counters[KD_COUNT_CHANGED], 1u)] = code;
    }
}
