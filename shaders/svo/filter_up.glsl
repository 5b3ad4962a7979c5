// Filter, dense levels upward: eight cells of the atlas to one of the next coarser level.

#include "shaders/include/tree_node.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/svo/filter_target.glsl"

// The atlas place of one of the eight, for one direction; offset: 0 or 1 on each axis.
ivec3 source_place(ivec3 offset, int direction);

vec4 load(ivec3 offset, int direction)
{
    vec4 v = imageLoad(atlas, source_place(offset, direction));
    return vec4(v.a > 0.0 ? v.rgb / v.a : vec3(0.0), v.a);
}

vec4 along(int axis, bool reverse)
{
    ivec3 step = ivec3(equal(ivec3(0, 1, 2), ivec3(axis)));
    ivec3 a = step.zxy, b = step.yzx;
    int direction = 2 * axis + int(reverse);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        ivec3 column = (k & 1) * a + (k >> 1) * b;
        vec4 front = load(reverse ? column + step : column, direction), back = load(reverse ? column : column + step, direction);
        sum += behind(front.rgb, front.a, back.rgb, back.a);
    }
    return column_mean(sum);
}
