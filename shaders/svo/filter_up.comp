// Filter, dense levels upward: eight cells of the atlas to one of the next coarser level. Serves two steps: a cascade's
// cells become the central half of the next cascade's, and the outermost cascade's become the levels above it.
// One invocation a target cell; cells without anything below end at once, unless they had something in the frame before.
layout(local_size_x = 64) in;

#include "shaders/include/tree_node.glsl"
#include "shaders/include/morton.glsl"

// x: cells along an edge of the target block (a power of two), y: first word of the source's occupancy, z: of the target's,
// w: first word of this step in `was`. from, to: xyz low corner of source and target block in the atlas; to.w: offset of the
// block inside the target's level.
layout(std140, binding = 0) uniform pass_block { uvec4 pass; ivec4 from; ivec4 to; };
layout(std430, binding = 0) buffer occupancy_block { uint occupancy[]; };
layout(std430, binding = 1) buffer was_block { uint was[]; };
layout(binding = 0, rgba16f) uniform image3D atlas;

// Where there is one direction's value of one source cell: radiance and depth.
vec4 load(ivec3 cell, int direction)
{
    vec4 v = imageLoad(atlas, from.xyz + cell + ivec3(direction * KD_DENSE, 0, 0));
    return vec4(v.a > 0.0 ? v.rgb / v.a : vec3(0.0), v.a);
}

vec4 along(ivec3 low, int axis, bool reverse)
{
    ivec3 step = ivec3(equal(ivec3(0, 1, 2), ivec3(axis)));
    ivec3 a = step.zxy, b = step.yzx;
    int direction = 2 * axis + int(reverse);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        ivec3 column = low + (k & 1) * a + (k >> 1) * b;
        vec4 front = load(reverse ? column + step : column, direction), back = load(reverse ? column : column + step, direction);
        sum += behind(front.rgb, front.a, back.rgb, back.a);
    }
    return column_mean(sum);
}

void main()
{
    uint code = gl_GlobalInvocationID.x;
    if (code >= pass.x * pass.x * pass.x)
        return;
    bool now = (occupancy[pass.y + (code >> 2)] >> (8u * (code & 3u)) & 255u) != 0u;
    if (!now && was[pass.w + code] == 0u)
        return;
    was[pass.w + code] = uint(now);
    uvec3 cell = morton_decode(code);
    ivec3 target = to.xyz + ivec3(cell) + to.w;
    for (int axis = 0; axis < 3; axis++) {
        vec4 forth = vec4(0.0), back = vec4(0.0);
        if (now) {
            forth = along(ivec3(cell) * 2, axis, false);
            back = along(ivec3(cell) * 2, axis, true);
        }
        imageStore(atlas, target + ivec3(2 * axis * KD_DENSE, 0, 0), forth);
        imageStore(atlas, target + ivec3((2 * axis + 1) * KD_DENSE, 0, 0), back);
    }
    if (now) {
        uint bit = morton_encode(cell + uint(to.w));
        atomicOr(occupancy[pass.z + (bit >> 5)], 1u << (bit & 31u));
    }
}
