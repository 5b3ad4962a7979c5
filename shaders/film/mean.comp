/* Adds a rendered picture to the mean that a frame is: of n x n pixels and of all sub-frames, in linear light. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/film.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = KD_BIND_PASS) uniform film_pass { kd_film_params film; };
layout(binding = KD_UNIT_PICTURE) uniform sampler2D picture;
layout(binding = 0, rgba32f) uniform image2D mean_image;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(mean_image))))
        return;
    int n = int(film.mode.x);
    vec4 sum = vec4(0.0);
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++)
            sum += texelFetch(picture, pixel * n + ivec2(x, y), 0);
    sum *= film.weight.x;
    if (film.mode.y == 0u)
        sum += imageLoad(mean_image, pixel);
    imageStore(mean_image, pixel, sum);
}
