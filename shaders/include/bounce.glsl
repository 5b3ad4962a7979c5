// Entries of the buffer "bounce", shaders/shared/bounce.h.

#include "shaders/shared/bounce.h"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/half_pack.glsl"

// A dense cell, counted from its cascade's low corner, to one counted from the world's origin.
ivec3 bounce_world_cell(uint cascade, ivec3 cell)
{
    return cell + (tree.origin[cascade].xyz >> int(tree.info.w));
}

uint bounce_first_entry(uint cascade, ivec3 world_cell)
{
    uvec3 at = uvec3(world_cell & (KD_DENSE - 1));
    return (((cascade * KD_DENSE + at.z) * KD_DENSE + at.y) * KD_DENSE + at.x) * KD_BOUNCE_WORDS;
}

uint bounce_identity(ivec3 world_cell)
{
    uvec3 window = uvec3(world_cell >> KD_DENSE_LOG2) & 255u;
    return window.x | window.y << 8 | window.z << 16 | uint(int(log2(tree.light.y)) + 128) << 24;
}

// Of the same cell, in whatever unit?
bool bounce_is_of(uint kept, uint identity) { return ((kept ^ identity) & 0xFFFFFFu) == 0u; }

// What kept light is multiplied by to be in the unit of now, a power of two.
float bounce_in_unit(uint kept, uint identity)
{
    return uintBitsToFloat(uint(clamp(int(identity >> 24) - int(kept >> 24), -64, 64) + 127) << 23);
}
