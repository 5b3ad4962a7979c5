/* Mixes the picture with the one before, while the camera moves: each pixel is looked up where what it shows was. So
 * what one sample a pixel shows of edges, leaves, shadows and maps becomes a mean of several places. Things that move
 * by themselves are left as they are. LDR: makes what is shown too.
 * Source  Karis 2014, High Quality Temporal Supersampling; Catmull, Rom 1974 */

#include "shaders/resolve/screen.glsl"
#include "shaders/shared/bindings.h"
#include "shaders/include/gbuffer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform steady_pass { kd_steady_params steady; };
layout(binding = KD_UNIT_PICTURE) uniform sampler2D picture; /* row 0 on top, as is the one before */
layout(binding = KD_UNIT_BEFORE_DIFFUSE) uniform sampler2D picture_before;
layout(binding = 0, rgba16f) uniform writeonly image2D mixed_image;
layout(binding = 1, rgba8) uniform writeonly image2D ldr_image;

/* The nearest of the pixel and its four diagonal neighbours: at an edge the mixture follows what is in front. z: its
 * depth. */
vec3 nearest_surface(ivec2 pixel, ivec2 size)
{
    vec3 nearest = vec3(pixel, gbuffer_load_depth(pixel));
    for (int i = 0; i < 4; i++) {
        ivec2 p = clamp(pixel + ivec2((i & 1) * 2 - 1, (i >> 1) * 2 - 1), ivec2(0), size - 1);
        float depth = gbuffer_load_depth(p);
        nearest = depth < nearest.z ? vec3(p, depth) : nearest;
    }
    return nearest;
}

/* Pixels from here to where what stands still was, y upwards. The background is infinitely far away. */
vec2 way_back(vec3 nearest, vec2 size)
{
    vec3 p_ws = gbuffer_position(ivec2(nearest.xy), nearest.z);
    vec4 before = steady.before * (nearest.z < 1.0 ? vec4(p_ws, 1.0) : vec4(view_direction(p_ws), 0.0));
    return before.w > 0.0 ? (before.xy / before.w * 0.5 + 0.5) * size - (nearest.xy + 0.5) : vec2(0.0);
}

vec4 cubic(float t)
{
    return vec4(t * (t * (1.0 - 0.5 * t) - 0.5), 1.0 + t * t * (1.5 * t - 2.5), t * (0.5 + t * (2.0 - 1.5 * t)),
                t * t * (0.5 * t - 0.5));
}

/* The picture before between its texels, by a cubic, which keeps what is sharp; its corners weigh next to nothing. */
vec3 look_up(vec2 at, ivec2 last)
{
    ivec2 low = ivec2(floor(at));
    vec4 x = cubic(at.x - float(low.x)), y = cubic(at.y - float(low.y));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 12; i++) {
        ivec2 o = i < 8 ? ivec2(i & 3, 1 + (i >> 2)) : ivec2(1 + (i & 1), i < 10 ? 0 : 3);
        float weight = x[o.x] * y[o.y];
        sum += weight * vec4(texelFetch(picture_before, clamp(low + o - 1, ivec2(0), last), 0).rgb, 1.0);
    }
    return max(sum.rgb / sum.a, vec3(0.0));
}

/* Bright pixels count less, so that one does not outweigh many of what is shown. */
float weight_of(vec3 c) { return 1.0 / (1.0 + color_luminance(c) * kd_view.lens.z); }

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(kd_view.size.xy), last = size - 1;
    if (any(greaterThanEqual(pixel, size)))
        return;
    ivec2 top_down = ivec2(pixel.x, last.y - pixel.y);
    vec4 now = texelFetch(picture, top_down, 0);
    vec3 low = now.rgb, high = now.rgb; /* what was seen before may not be seen any more */
    for (int i = 0; i < 4; i++) {
        int k = 2 * i + 1;
        vec3 c = texelFetch(picture, clamp(top_down + ivec2(k % 3, k / 3) - 1, ivec2(0), last), 0).rgb;
        low = min(low, c);
        high = max(high, c);
    }
    vec3 nearest = nearest_surface(pixel, size);
    vec2 way = way_back(nearest, vec2(size)), at = vec2(top_down) + vec2(way.x, -way.y);
    bool seen = all(greaterThanEqual(at, vec2(-0.5))) && all(lessThan(at, vec2(size) - 0.5));
    bool moves = texelFetch(gbuffer_material, ivec2(nearest.xy), 0).a > 0.5 && nearest.z < 1.0;
    float share = seen && !moves ? steady.share.x : 0.0;
    vec3 old = clamp(look_up(at, last), low, high);
    float w_old = share * weight_of(old), w_now = (1.0 - share) * weight_of(now.rgb);
    vec3 c = share > 0.0 ? (old * w_old + now.rgb * w_now) / (w_old + w_now) : now.rgb;
    imageStore(mixed_image, top_down, vec4(c, now.a));
#ifdef LDR
    imageStore(ldr_image, top_down, vec4(screen_view(c, steady.mode.x, kd_view.lens.z, steady.mode.y), 1.0));
#endif
}
