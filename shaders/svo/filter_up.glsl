// Filter, dense levels upward: eight cells of the atlas to one of the next coarser level.

#include "shaders/include/tree_params.glsl"
#include "shaders/include/tree_node.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/svo/filter_target.glsl"

// The atlas place of one of the eight; offset: 0 or 1 on each axis.
atlas_cell source_place(ivec3 offset);

atlas_cell source[8];
vec3 depths[8]; // along the ways at hand

vec4 load(int k, int axis, int direction)
{
    float depth = depths[k][axis];
    return vec4(depth > 0.0 ? atlas_load_radiance(source[k], direction) / depth : vec3(0.0), depth);
}

vec4 along(int axis, int reverse)
{
    int step = 1 << axis, a = 1 << ((axis + 1) % 3), b = 1 << ((axis + 2) % 3), direction = 2 * axis + reverse;
    vec4 sum = vec4(0.0);
    float deep = 0.0;
    for (int k = 0; k < 4; k++) {
        int low = (k & 1) * a + (k >> 1) * b;
        vec4 front = load(low + reverse * step, axis, direction), back = load(low + (1 - reverse) * step, axis, direction);
        sum += behind(front.rgb, front.a, back.rgb, back.a);
        deep += front.a + back.a;
    }
    return column_mean(sum, deep, tree_is_strict());
}

// Writes what the eight are together; returns whether that is anything.
bool put_mean_of_eight(atlas_cell at)
{
    float most = 0.0;
    for (int k = 0; k < 8; k++)
        source[k] = source_place(ivec3(k, k >> 1, k >> 2) & 1);
    for (int reverse = 0; reverse < 2; reverse++) {
        for (int k = 0; k < 8; k++)
            depths[k] = atlas_load_depth(source[k], reverse);
        vec4 x = along(0, reverse), y = along(1, reverse), z = along(2, reverse);
        atlas_put(at, reverse, x, y, z);
        most = max(most, max(x.a, max(y.a, z.a)));
    }
    return most > 0.0;
}
