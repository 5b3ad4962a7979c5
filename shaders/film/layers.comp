/* Splits a picture into what it is made of, for files with layers. Light and albedo are means over n x n rendered
 * pixels and all sub-frames; normal, depth and motion are those of the nearest rendered pixel at the frame's own
 * time, since a mean of two surfaces is neither. What blended surfaces hide is missing in the parts behind them.
 *
 * Beside what shade.glsl asks for, BLENDED and TINTED are those of resolve.comp; LAYERS_FORMAT says how slices
 * are kept. */

#include "shaders/shared/film.h"
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/shade.glsl"
#include "shaders/include/sky.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform film_pass { kd_film_params film; };
layout(binding = KD_UNIT_PICTURE) uniform sampler2D picture;
layout(binding = KD_UNIT_MOTION) uniform sampler2D motion_map;
#ifdef BLENDED
layout(binding = KD_UNIT_BLENDED) uniform sampler2D blended_map;
#ifdef TINTED
layout(binding = KD_UNIT_BLENDED_TINT) uniform sampler2D hidden_map;
#endif
#endif
layout(binding = 0, LAYERS_FORMAT) uniform image2DArray slices;

#define GATHERED_IS_THERE (film.mode.w != 0u)
#define GATHERED_UNIT film.weight.y
#include "shaders/resolve/gathered.glsl"

struct parts {
    vec3 direct, indirect, specular, emission, albedo;
    vec4 blended;
};

parts parts_of(surface s, ivec2 pixel)
{
    parts p = parts(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec4(0.0));
    vec3 v = -view_direction(s.position_ws);
    if (!s.hit)
        p.emission = sky_radiance(-v);
    else
        p.emission = s.emissive;
    if (s.hit && !s.unlit) {
        p.albedo = s.albedo;
        p.direct = direct_light(s, v);
        vec3 diffuse = gathered_diffuse(s, pixel).rgb;
        p.specular = indirect_specular(s, v, diffuse, gathered_specular(s, pixel));
        p.indirect = (1.0 - coat_share(s, v)) * indirect_diffuse(s, v, diffuse) + p.specular;
    }
#ifdef BLENDED
    p.blended = texelFetch(blended_map, pixel, 0);
#ifdef TINTED
    vec3 seen = 1.0 - texelFetch(hidden_map, pixel, 0).rgb;
#else
    float seen = 1.0 - p.blended.a;
#endif
    p.direct *= seen;
    p.indirect *= seen;
    p.specular *= seen;
    p.emission *= seen;
#endif
    return p;
}

/* To where it was, in rendered pixels, y upwards. The background is infinitely far away. */
vec2 motion_of(surface s, ivec2 pixel)
{
    if (s.hit)
        return texelFetch(motion_map, pixel, 0).xy;
    vec4 before = film.previous_view_projection * vec4(view_direction(s.position_ws), 0.0);
    if (before.w <= 0.0)
        return vec2(0.0);
    return (before.xy / before.w * 0.5 + 0.5) * vec2(kd_view.size.xy) - (vec2(pixel) + 0.5);
}

void add(ivec2 at, uint slice, vec4 value)
{
    ivec3 where = ivec3(at, int(slice));
    value *= film.weight.x;
    if (film.mode.y == 0u)
        value += imageLoad(slices, where);
    imageStore(slices, where, value);
}

/* Depth in two halfs, the second of which holds what the first one lacks. */
vec2 split_depth(surface s)
{
    if (!s.hit)
        return vec2(-1.0, 0.0);
    float z = view_depth(s.depth), coarse = unpackHalf2x16(packHalf2x16(vec2(z, 0.0))).x;
    return isinf(coarse) ? vec2(65504.0, 0.0) : vec2(coarse, z - coarse);
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(slices).xy)))
        return;
    int n = int(film.mode.x);
    vec4 final = vec4(0.0);
    parts sum = parts(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec4(0.0));
    surface nearest;
    ivec2 nearest_pixel;
    nearest.depth = 2.0;
    for (int i = 0; i < n * n; i++) {
        ivec2 top_down = at * n + ivec2(i % n, i / n);
        ivec2 pixel = ivec2(top_down.x, int(kd_view.size.y) - 1 - top_down.y);
        surface s = gbuffer_load(pixel);
        parts p = parts_of(s, pixel);
        final += texelFetch(picture, top_down, 0);
        sum.direct += p.direct;
        sum.indirect += p.indirect;
        sum.specular += p.specular;
        sum.emission += p.emission;
        sum.albedo += p.albedo;
        sum.blended += p.blended;
        if (s.depth < nearest.depth) {
            nearest = s;
            nearest_pixel = pixel;
        }
    }
    add(at, KD_LAYER_FINAL, final);
    add(at, KD_LAYER_DIRECT, vec4(sum.direct, 0.0));
    add(at, KD_LAYER_INDIRECT, vec4(sum.indirect, 0.0));
    add(at, KD_LAYER_SPECULAR, vec4(sum.specular, 0.0));
    add(at, KD_LAYER_EMISSION, vec4(sum.emission, 0.0));
    add(at, KD_LAYER_BLENDED, sum.blended);
    add(at, KD_LAYER_ALBEDO, vec4(sum.albedo, 0.0));
    if (film.mode.z == 0u)
        return;
    vec3 normal = nearest.hit ? nearest.normal_ws : vec3(0.0);
    vec2 motion = motion_of(nearest, nearest_pixel) / float(n);
    imageStore(slices, ivec3(at, int(KD_LAYER_NORMAL)), vec4(normal, 0.0));
    imageStore(slices, ivec3(at, int(KD_LAYER_MOTION)), vec4(motion.x, -motion.y, split_depth(nearest)));
}
