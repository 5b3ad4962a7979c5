/* Adds up what reaches the eye from each pixel: emission, light straight from the lights, and the gathered
 * light. Writes the radiance of the chosen view and, with LDR, its picture; row 0 on top.
 *
 * Beside what shade.glsl asks for, BLENDED says when compiling that there are blended surfaces in front, TINTED
 * that they let colours through unequally. LISTED: a group a listed tile; EMPTY besides: of the list of those that
 * show no surface. */

#include "shaders/resolve/screen.glsl"
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/shade.glsl"
#include "shaders/include/sky.glsl"

#ifdef LISTED
#include "shaders/include/tiles.glsl"
layout(local_size_x = KD_TILE_EDGE, local_size_y = KD_TILE_EDGE) in;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
layout(std140, binding = KD_BIND_PASS) uniform resolve_pass { kd_resolve_params params; };
#ifdef BLENDED
layout(binding = KD_UNIT_BLENDED) uniform sampler2D blended; /* rgb: their light, a: share that they hide */
#ifdef TINTED
layout(binding = KD_UNIT_BLENDED_TINT) uniform sampler2D blended_hidden; /* rgb: the same by colour */
#endif
#endif
layout(binding = 0, rgba16f) uniform writeonly image2D hdr_image;
layout(binding = 1, rgba8) uniform writeonly image2D ldr_image;

#define GATHERED_IS_THERE (params.mode.z != 0u)
#include "shaders/resolve/gathered.glsl"

vec3 background(ivec2 pixel)
{
    if (show != KD_SHOW_FINAL && show != KD_SHOW_DIRECT)
        return vec3(0.0);
    return sky_radiance(view_direction(gbuffer_position(pixel, 1.0)));
}

/* rgb: light, a: 1 where there is a surface */
vec4 behind(ivec2 pixel)
{
#ifdef EMPTY
    return vec4(background(pixel), 0.0);
#else
    surface s = gbuffer_load(pixel);
    return vec4(s.hit ? shade(s, gathered_diffuse(s, pixel), gathered_specular(s, pixel)) : background(pixel),
                s.hit ? 1.0 : 0.0);
#endif
}

/* Returns false where there is none. */
bool find_pixel(out ivec2 pixel)
{
#ifdef LISTED
#ifdef EMPTY
    const uint list = KD_TILE_EMPTY;
#else
    const uint list = KD_TILE_SURFACES;
#endif
    uint item = tile_items[tile_place(list, gl_WorkGroupID.y * KD_TILE_ROW + gl_WorkGroupID.x)];
    if (item == KD_TILE_NONE)
        return false;
    uvec2 tile = tile_unpack(item);
    pixel = ivec2(tile * KD_TILE_EDGE + gl_LocalInvocationID.xy);
#ifdef TILED
    tile_here = tile_number(tile);
#endif
#else
    pixel = ivec2(gl_GlobalInvocationID.xy);
#endif
    return all(lessThan(pixel, ivec2(kd_view.size.xy)));
}

void main()
{
    ivec2 pixel;
    if (!find_pixel(pixel))
        return;
    vec4 seen = behind(pixel);
    vec3 c = seen.rgb;
#ifdef BLENDED
    vec4 front = texelFetch(blended, pixel, 0);
#ifdef TINTED
    c = front.rgb + (1.0 - texelFetch(blended_hidden, pixel, 0).rgb) * c;
#else
    c = front.rgb + (1.0 - front.a) * c;
#endif
#endif
    c = min(c, vec3(65504.0));
    ivec2 top_down = ivec2(pixel.x, int(kd_view.size.y) - 1 - pixel.y);
    imageStore(hdr_image, top_down, vec4(c, seen.a));
#ifdef LDR
    imageStore(ldr_image, top_down, vec4(screen_view(c, show, kd_view.lens.z, params.mode.y), 1.0));
#endif
}
