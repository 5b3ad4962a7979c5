// Did the occupancy of a leaf cell change since the frame before? Asks "svo.changes" (components/svo.h); the shader that includes
// this says where it is bound: #define KD_CHANGES_BINDING.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/morton.glsl"

layout(std430, binding = KD_CHANGES_BINDING) readonly buffer changes_block { uint changes[]; };

// cell: of cascade c, from its low corner
bool cell_changed(uint c, ivec3 cell)
{
    uint bit = cascade_first_bit(c) + morton_encode(cell_wrap(c, cell));
    return (changes[bit >> 5] >> (bit & 31u) & 1u) != 0u;
}
