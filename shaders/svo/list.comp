// Lists the occupied nodes of a level in order of their codes: node number (rank) to code, cascade above the Morton code.
// At the dense level it also writes the number of every occupied dense cell into the index that the tracer reads.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"
#include "shaders/include/morton.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: words, y: first word, z: capacity of the list, w: first entry
layout(std430, binding = 0) readonly buffer masks_block { uint masks[]; };
layout(std430, binding = 1) readonly buffer ranks_block { uint ranks[]; };
layout(std430, binding = 2) writeonly buffer list_block { uint list[]; };
#ifdef KD_DENSE_LEVEL
layout(std430, binding = 3) writeonly buffer index_block { uint index[]; };
#endif

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint bits = masks[pass.y + word], rank = ranks[pass.y + word];
    while (bits != 0u) {
        uint code = word * 32u + uint(findLSB(bits));
        if (rank < pass.z) {
            list[pass.w + rank] = code;
#ifdef KD_DENSE_LEVEL
            uint cascade = code >> (3 * KD_DENSE_LOG2);
            uvec3 cell = morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u));
            index[((cascade * KD_DENSE + cell.z) * KD_DENSE + cell.y) * KD_DENSE + cell.x] = rank;
#endif
        }
        bits &= bits - 1u;
        rank++;
    }
}
