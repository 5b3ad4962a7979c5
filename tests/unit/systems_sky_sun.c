/* The sun in a sky's picture: what is one, what is not, and that its light is neither lost nor doubled. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "components/sky_sun.h"

enum { WIDTH = 256, HEIGHT = 128 };
static const float PI = 3.14159265f;
static float rgb[WIDTH * HEIGHT * 3], rest[WIDTH * HEIGHT * 3];
static const kd_sky_map map = {WIDTH, HEIGHT, rgb};

/* A sky of 0.5, 1, 2, and within `degrees` of `way` the colour times `radiance`. */
static void paint(kd_vec3 way, float degrees, kd_vec3 radiance)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            kd_vec3 d = kd_sky_direction((kd_vec2){((float)x + 0.5f) / WIDTH, ((float)y + 0.5f) / HEIGHT});
            bool inside = kd_vec3_dot(d, way) >= cosf(degrees * PI / 180);
            float *t = rgb + (y * WIDTH + x) * 3;
            t[0] = inside ? radiance.x : 0.5f;
            t[1] = inside ? radiance.y : 1;
            t[2] = inside ? radiance.z : 2;
        }
}

/* Irradiance of a map on what faces `way`, over all that lies in front of it. */
static kd_vec3 irradiance(const float *texels, kd_vec3 way)
{
    double sum[3] = {0};
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            kd_vec3 d = kd_sky_direction((kd_vec2){((float)x + 0.5f) / WIDTH, ((float)y + 0.5f) / HEIGHT});
            double area =
                sin(3.14159265358979 * (y + 0.5) / HEIGHT) * (double)(PI / HEIGHT) * (double)(2 * PI / WIDTH);
            for (int k = 0; k < 3; k++)
                sum[k] +=
                    area * fmax((double)kd_vec3_dot(d, way), 0) * (double)texels[(y * WIDTH + x) * 3 + k];
        }
    return (kd_vec3){(float)sum[0], (float)sum[1], (float)sum[2]};
}

static void expect_sun(kd_vec3 way)
{
    kd_sky_sun sun;
    way = kd_vec3_normalize(way, (kd_vec3){0, 1, 0});
    paint(way, 1.5f, (kd_vec3){40000, 30000, 20000});
    assert_true(kd_sky_sun_find(&map, &sun));
    assert_true(kd_vec3_dot(sun.direction, way) > cosf(0.7f * PI / 180)); /* half a texel */
    kd_sky_sun_remove(&map, &sun, rest);
    kd_vec3 all = irradiance(rgb, way), without = irradiance(rest, way);
    const float *a = &all.x, *b = &without.x, *light = &sun.irradiance.x, *round = &sun.round.x;
    for (int k = 0; k < 3; k++) {
        assert_true(fabsf(a[k] - b[k] - light[k]) < 0.002f * light[k]);
        assert_true(fabsf(round[k] - (k == 0 ? 0.5f : (float)k)) < 1e-4f);
        assert_true(b[k] < 1.001f * PI * (k == 0 ? 0.5f : (float)k));
    }
}

static void sun_is_found_and_its_light_kept(void **state)
{
    (void)state;
    expect_sun((kd_vec3){0.3f, 0.7f, -0.5f});
    expect_sun((kd_vec3){0, 0.4f, 1});  /* over the seam */
    expect_sun((kd_vec3){0.01f, 1, 0}); /* beside the pole */
}

static bool finds_one(void)
{
    kd_sky_sun sun;
    bool found = kd_sky_sun_find(&map, &sun);
    assert_true(found == (kd_vec3_dot(sun.irradiance, sun.irradiance) > 0));
    return found;
}

static void what_is_wide_or_dim_is_no_sun(void **state)
{
    const kd_vec3 way = {0, 0.8f, -0.6f};
    (void)state;
    paint(way, 0, (kd_vec3){0, 0, 0}); /* nothing */
    assert_false(finds_one());
    paint(way, 20, (kd_vec3){100, 100, 100}); /* a window */
    assert_false(finds_one());
    paint(way, 1.5f, (kd_vec3){5, 5, 5}); /* a lantern: a hundredth of the light */
    assert_false(finds_one());
    memset(rgb, 0, sizeof rgb);
    assert_false(finds_one());
    const kd_sky_map coarse = {WIDTH, KD_SKY_SUN_ROWS - 1, rgb}; /* texels as large as a sun may be */
    kd_sky_sun sun;
    rgb[20 * WIDTH * 3] = 1e4f;
    assert_false(kd_sky_sun_find(&coarse, &sun));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sun_is_found_and_its_light_kept),
        cmocka_unit_test(what_is_wide_or_dim_is_no_sun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
