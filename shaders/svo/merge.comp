// First step up the tree. One invocation a word of leaf parents, which is eight words of cells in Morton order: brings what was
// built anew into the static mask, joins the layers, reduces eight cells to one bit of their parent, and tells which parents
// are touched: the static layer was built anew there, or something dynamic is or was there.
layout(local_size_x = 64) in;

#include "shaders/shared/voxel.h"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parent words, y: 1 when static cells were built anew, z: sparse levels, w: first parent word
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) buffer static_block { uint mask_static[]; };
layout(std430, binding = 2) readonly buffer dynamic_block { uint mask_dynamic[]; };
layout(std430, binding = 3) readonly buffer fresh_block { uint fresh[]; };
layout(std430, binding = 4) readonly buffer stale_block { uint stale[]; }; // bits of dense cells
layout(std430, binding = 5) writeonly buffer parents_block { uint parents[]; };
layout(std430, binding = 6) buffer touched_block { uint touched[]; };      // bits of parents; then those with dynamic cells
#ifdef KD_CHANGES
layout(std430, binding = 7) buffer changes_block { uint change[]; };       // XOR of occupancy; then the occupancy itself
#endif

// Spreads the low four bits to bytes of ones.
uint bytes_of(uint four)
{
    uint ones = (four & 1u) | (four & 2u) << 7 | (four & 4u) << 14 | (four & 8u) << 21;
    return ones * 255u;
}

// Cells of a word that lie in stale bricks. `levels`: from the dense cells down to the level of the word.
uint stale_cells(uint levels, uint word)
{
    if (levels == 0u)
        return stale[word];
    if (levels == 1u)
        return bytes_of(stale[word >> 3] >> (4u * (word & 7u)));
    uint brick = levels == 2u ? word >> 1 : word >> 4;
    return (stale[brick >> 5] >> (brick & 31u) & 1u) != 0u ? KD_EMPTY : 0u;
}

uint parents_of(uint cells)
{
    uint four = 0u;
    for (uint k = 0u; k < 4u; k++)
        four |= uint(((cells >> (8u * k)) & 255u) != 0u) << k;
    return four;
}

uint renew(uint at)
{
    uint before = mask_static[at], kept = before & ~stale_cells(pass.z, at), now = kept | fresh[at];
    if (now != before) {
        mask_static[at] = now;
        atomicAdd(counters[KD_COUNT_STATIC], uint(bitCount(now)) - uint(bitCount(before)));
    }
    return now;
}

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint joined = 0u, moving = 0u;
    for (uint i = 0u; i < 8u; i++) {
        uint at = word * 8u + i;
        uint still = pass.y != 0u ? renew(at) : mask_static[at], bits = mask_dynamic[at];
        moving |= parents_of(bits) << (4u * i);
        joined |= parents_of(bits | still) << (4u * i);
    }
    parents[pass.w + word] = joined;
    uint stale_parents = pass.y != 0u ? stale_cells(pass.z - 1u, word) : 0u;
    touched[word] = (stale_parents | moving | touched[pass.x + word]) & joined;
    touched[pass.x + word] = moving;
}
