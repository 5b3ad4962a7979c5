// Did leaves come or go since the frame before? Asks what kd_svo_bind_changes() binds (components/svo.h); the shader that includes
// this says where: #define KD_CHANGES_BINDING.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/morton.glsl"

layout(std430, binding = KD_CHANGES_BINDING) readonly buffer changes_block { uint changes[]; }; // bits of dense cells

// Around a cell of cascade c, from its low corner: in its dense cell; where that is two cells wide, in the eight of a block.
bool cells_changed_around(uint c, ivec3 cell)
{
    uint code = c << (3 * KD_DENSE_LOG2) | morton_encode(dense_wrap(c, cell >> int(tree.info.w)));
    uint bits = tree.info.w == 1u ? 255u << (code & 24u) : 1u << (code & 31u);
    return (changes[code >> 5] & bits) != 0u;
}
