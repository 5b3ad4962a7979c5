/* Means of a sky over discs, from a pyramid of halved maps: each disc is sampled at points spread evenly over
 * it, at the level whose texels are as large as a point's share. Rows count by the solid angle of their
 * texels. */

#include "systems/sky/cones.h"

#include <math.h>
#include <stdlib.h>

#include "runtime/core/half.h"
#include "shaders/shared/sky.h"

enum { LEVELS_MAX = 16, POINTS = 32 };

static const float PI = 3.14159265358979f;

typedef struct pyramid {
    kd_sky_map levels[LEVELS_MAX];
    uint32_t count;
    float *texels; /* of all levels but the first, which is borrowed */
} pyramid;

static uint32_t halved(uint32_t size)
{
    return size > 1 ? size / 2 : 1;
}

static void halve(const kd_sky_map *from, float *to)
{
    uint32_t width = halved(from->width), height = halved(from->height);
    for (uint32_t y = 0; y < height; y++) {
        uint32_t y0 = from->height > 1 ? 2 * y : 0, y1 = from->height > 1 ? y0 + 1 : 0;
        float a = sinf(PI * ((float)y0 + 0.5f) / (float)from->height),
              b = sinf(PI * ((float)y1 + 0.5f) / (float)from->height), scale = 0.5f / (a + b);
        for (uint32_t x = 0; x < width; x++) {
            uint32_t x0 = from->width > 1 ? 2 * x : 0, x1 = from->width > 1 ? x0 + 1 : 0;
            const float *above = from->rgb + (size_t)y0 * from->width * 3,
                        *below = from->rgb + (size_t)y1 * from->width * 3;
            for (uint32_t c = 0; c < 3; c++)
                to[((size_t)y * width + x) * 3 + c] = scale * (a * (above[x0 * 3 + c] + above[x1 * 3 + c]) +
                                                               b * (below[x0 * 3 + c] + below[x1 * 3 + c]));
        }
    }
}

static bool pyramid_make(const kd_sky_map *map, pyramid *p)
{
    size_t texels = 0;
    uint32_t w = map->width, h = map->height;
    p->levels[0] = *map;
    for (p->count = 1; p->count < LEVELS_MAX && (w > 4 || h > 4); p->count++) {
        w = halved(w);
        h = halved(h);
        p->levels[p->count] = (kd_sky_map){w, h, NULL};
        texels += (size_t)w * h;
    }
    p->texels = malloc((texels > 0 ? texels : 1) * 3 * sizeof *p->texels);
    float *next = p->texels;
    for (uint32_t i = 1; p->texels != NULL && i < p->count; i++) {
        halve(&p->levels[i - 1], next);
        p->levels[i].rgb = next;
        next += (size_t)p->levels[i].width * p->levels[i].height * 3;
    }
    return p->texels != NULL;
}

/* The level whose rows are as high as `angle`, rounded to finer ones. */
static const kd_sky_map *pick_level(const pyramid *p, float angle)
{
    uint32_t i = 0;
    while (i + 1 < p->count && PI / (float)p->levels[i + 1].height <= angle)
        i++;
    return &p->levels[i];
}

static kd_vec3 octahedral(uint32_t x, uint32_t y)
{
    float u = 2 * (float)x / (KD_SKY_EDGE - 1) - 1, v = 2 * (float)y / (KD_SKY_EDGE - 1) - 1;
    kd_vec3 d = {u, v, 1 - fabsf(u) - fabsf(v)};
    if (d.z < 0) {
        d.x = (1 - fabsf(v)) * (u >= 0 ? 1.0f : -1.0f);
        d.y = (1 - fabsf(u)) * (v >= 0 ? 1.0f : -1.0f);
    }
    return kd_vec3_normalize(d, (kd_vec3){0, 0, 1});
}

/* Points of a spiral: equal shares of the cap in height over its axis, turned by the golden angle. */
static kd_vec3 disc_mean(const kd_sky_map *level, kd_vec3 axis, float cosine)
{
    kd_vec3 hint = fabsf(axis.y) < 0.9f ? (kd_vec3){0, 1, 0} : (kd_vec3){1, 0, 0}, sum = {0, 0, 0};
    kd_vec3 right = kd_vec3_normalize(kd_vec3_cross(hint, axis), (kd_vec3){1, 0, 0}),
            up = kd_vec3_cross(axis, right);
    for (int i = 0; i < POINTS; i++) {
        float z = 1 - (1 - cosine) * ((float)i + 0.5f) / POINTS, r = sqrtf(fmaxf(1 - z * z, 0));
        float turn = 2.39996323f * (float)i;
        kd_vec3 d = kd_vec3_add(kd_vec3_scale(axis, z), kd_vec3_add(kd_vec3_scale(right, r * cosf(turn)),
                                                                    kd_vec3_scale(up, r * sinf(turn))));
        sum = kd_vec3_add(sum, kd_sky_sample(level, d));
    }
    return kd_vec3_scale(sum, 1.0f / POINTS);
}

bool sky_cones_make(const kd_sky_map *map, uint16_t *out)
{
    pyramid p;
    if (!pyramid_make(map, &p))
        return false;
    for (uint32_t layer = 0; layer < KD_SKY_LAYERS; layer++) {
        float half_angle = atanf((float)KD_SKY_TANGENT * exp2f((float)layer));
        const kd_sky_map *level = pick_level(&p, 2 * half_angle / sqrtf(POINTS));
        for (uint32_t y = 0; y < KD_SKY_EDGE; y++)
            for (uint32_t x = 0; x < KD_SKY_EDGE; x++, out += 4) {
                kd_vec3 c = disc_mean(level, octahedral(x, y), cosf(half_angle));
                out[0] = kd_half_from_float(c.x);
                out[1] = kd_half_from_float(c.y);
                out[2] = kd_half_from_float(c.z);
                out[3] = 0;
            }
    }
    free(p.texels);
    return true;
}
