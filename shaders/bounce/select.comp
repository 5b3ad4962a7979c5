// Lists the sides of occupied dense cells that gather light in this frame, one invocation for 32 cells of the mask. A cell's
// sides without matter have no light; cells have their turn in blocks of 4^3, new ones at once.
layout(local_size_x = 64) in;

#include "shaders/include/bounce.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/work_list_fill.glsl"
#include "shaders/bounce/side_item.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_bounce_params pass; };
layout(std430, binding = 1) buffer bounce_block { uint entries[]; };
layout(std430, binding = 2) readonly buffer masks_block { uint masks[]; };
layout(binding = KD_UNIT_TREE_DEPTH) uniform sampler3D tree_depths;

// Cells without matter on a side are not asked what arrives there.
const float LEAST_DEPTH = 0.05;

bool side_has_matter(ivec3 wrapped, uint cascade, int side)
{
    int direction = side ^ 1; // rays against the side's normal
    vec3 depths = texelFetch(tree_depths, wrapped + ivec3(0, 0, (int(cascade) * 2 + (direction & 1)) * KD_ATLAS_BLOCK + 1), 0).rgb;
    return depths[direction >> 1] > LEAST_DEPTH;
}

void list_sides(uint code, uint cascade, ivec3 wrapped, uint at)
{
    for (int side = 0; side < 6; side++) {
        if (!side_has_matter(wrapped, cascade, side)) {
            entries[at + uint(side)] = 0u;
            continue;
        }
        work_add(side_item(code, side));
    }
}

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.work.x)
        return;
    for (uint bits = masks[pass.work.y + word]; bits != 0u; bits &= bits - 1u) {
        uint code = word * 32u + uint(findLSB(bits)), cascade = code >> (3 * KD_DENSE_LOG2);
        uvec3 wrapped = morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u));
        ivec3 world_cell = bounce_world_cell(cascade, dense_unwrap(cascade, wrapped));
        uint at = bounce_first_entry(cascade, world_cell), identity = bounce_identity(world_cell);
        bool known = bounce_is_of(entries[at + 7u], identity) && pass.frame.x - entries[at + 6u] <= pass.frame.z;
        ivec3 block = world_cell >> 2;
        if (known && ((uint(block.x + 2 * block.y + 4 * block.z) ^ pass.frame.x) & (pass.frame.y - 1u)) != 0u)
            continue;
        list_sides(code, cascade, ivec3(wrapped), at);
        entries[at + 6u] = pass.frame.x;
        entries[at + 7u] = identity;
    }
}
