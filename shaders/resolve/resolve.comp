/* Adds up what reaches the eye from each pixel: emission, light straight from the lights, and the gathered
 * light. Writes the radiance of the chosen view and, with LDR, its picture; row 0 on top.
 *
 * Beside what shade.glsl asks for, BLENDED says when compiling that there are blended surfaces in front, TINTED
 * that they let colours through unequally, TILED that each tile has its list of local lights. */

#include "shaders/resolve/screen.glsl"
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/shade.glsl"
#include "shaders/include/sky.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
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
#define GATHERED_UNIT params.gathered.x
#include "shaders/resolve/gathered.glsl"

vec3 background(ivec2 pixel)
{
    if (show != KD_SHOW_FINAL && show != KD_SHOW_DIRECT)
        return vec3(0.0);
    return sky_radiance(view_direction(gbuffer_position(pixel, 1.0)));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(kd_view.size.xy))))
        return;
#ifdef TILED
    uvec2 tile = uvec2(pixel) / KD_TILE_EDGE;
    tile_here = tile.y * tile_counts().x + tile.x;
#endif
    surface s = gbuffer_load(pixel);
    vec3 c = s.hit ? shade(s, gathered_diffuse(s, pixel), gathered_specular(s, pixel)) : background(pixel);
#ifdef BLENDED
    vec4 front = texelFetch(blended, pixel, 0);
#ifdef TINTED
    c = front.rgb + (1.0 - texelFetch(blended_hidden, pixel, 0).rgb) * c;
#else
    c = front.rgb + (1.0 - front.a) * c;
#endif
#endif
    ivec2 top_down = ivec2(pixel.x, int(kd_view.size.y) - 1 - pixel.y);
    imageStore(hdr_image, top_down, vec4(min(c, vec3(65504.0)), s.hit ? 1.0 : 0.0));
#ifdef LDR
    imageStore(ldr_image, top_down, vec4(screen_view(c, show, kd_view.lens.z, params.mode.y), 1.0));
#endif
}
