#include "components/sky_map.h"

#include <math.h>

static const float PI = 3.14159265358979f;

kd_vec2 kd_sky_place(kd_vec3 d)
{
    float u = 0.5f + atan2f(d.x, -d.z) / (2 * PI);
    return (kd_vec2){u, acosf(fminf(fmaxf(d.y, -1), 1)) / PI};
}

kd_vec3 kd_sky_direction(kd_vec2 place)
{
    float azimuth = (place.x - 0.5f) * 2 * PI, polar = place.y * PI, s = sinf(polar);
    return (kd_vec3){s * sinf(azimuth), cosf(polar), -s * cosf(azimuth)};
}

void kd_sky_gradient(kd_vec3 zenith, kd_vec3 horizon, kd_vec3 ground, float *rgb)
{
    const float *level = &horizon.x;
    for (int y = 0; y < KD_SKY_GRADIENT_HEIGHT; y++) {
        float height = cosf(PI * ((float)y + 0.5f) / KD_SKY_GRADIENT_HEIGHT), share = fabsf(height);
        const float *end = height >= 0 ? &zenith.x : &ground.x;
        for (int x = 0; x < KD_SKY_GRADIENT_WIDTH; x++)
            for (int c = 0; c < 3; c++)
                rgb[(y * KD_SKY_GRADIENT_WIDTH + x) * 3 + c] = level[c] + (end[c] - level[c]) * share;
    }
}

static kd_vec3 mix(const float *a, const float *b, float t)
{
    return (kd_vec3){a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t};
}

kd_vec3 kd_sky_sample(const kd_sky_map *map, kd_vec3 direction)
{
    kd_vec2 place = kd_sky_place(direction);
    int32_t w = (int32_t)map->width, h = (int32_t)map->height;
    float x = place.x * (float)w - 0.5f, y = place.y * (float)h - 0.5f, left = floorf(x), top = floorf(y);
    int32_t x0 = ((int32_t)left % w + w) % w, x1 = (x0 + 1) % w;
    int32_t y0 = top < 0 ? 0 : (int32_t)top, y1 = (int32_t)top + 1 < h ? (int32_t)top + 1 : h - 1;
    y0 = y0 < h ? y0 : h - 1;
    const float *above = map->rgb + (size_t)y0 * map->width * 3,
                *below = map->rgb + (size_t)y1 * map->width * 3;
    kd_vec3 a = mix(above + x0 * 3, above + x1 * 3, x - left),
            b = mix(below + x0 * 3, below + x1 * 3, x - left);
    return mix(&a.x, &b.x, y - top);
}
