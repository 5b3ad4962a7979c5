/* Pictures brought to where their surfaces are a frame later: what moved by whole pixels is found again
 * without loss, what was hidden does not count, and what flickers has the value of its flicker. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/compare/compare.h"

enum { WIDTH = 40, HEIGHT = 30, COUNT = WIDTH * HEIGHT };

/* A wall 5 m away that faces the view, and its picture. */
typedef struct scene {
    float depth[COUNT], normal[3][COUNT], motion[2][COUNT], rgb[COUNT * 3];
} scene;

static scene before, now;
static float moved[COUNT * 3], map[COUNT];
static uint8_t seen[COUNT];

static kd_surfaces surfaces_of(const scene *s)
{
    return (kd_surfaces){s->depth, {s->normal[0], s->normal[1], s->normal[2]}, {s->motion[0], s->motion[1]}};
}

/* Red rises to the right, green downwards, blue is a check: the wall goes x to the right and y down. */
static void fill_wall(scene *s, float x, float y)
{
    memset(s, 0, sizeof *s);
    for (int i = 0; i < COUNT; i++) {
        float u = (float)(i % WIDTH) - x, v = (float)(i / WIDTH) - y;
        s->depth[i] = 5;
        s->normal[2][i] = 1;
        s->motion[0][i] = -x;
        s->motion[1][i] = -y;
        s->rgb[i * 3] = 0.25f + u / 128;
        s->rgb[i * 3 + 1] = 0.25f + v / 128;
        s->rgb[i * 3 + 2] = fmodf(floorf(u) + floorf(v) + 100, 2) > 0.5f ? 1.0f : 0.0f;
    }
}

static size_t reproject(void)
{
    kd_surfaces a = surfaces_of(&before), b = surfaces_of(&now);
    return kd_reproject(&a, before.rgb, &b, now.rgb, WIDTH, HEIGHT, moved, seen);
}

static double flicker(void)
{
    double mean;
    assert_int_equal(kd_flip_ldr(now.rgb, moved, WIDTH, HEIGHT, 0, map, &mean), KD_OK);
    return kd_mean_seen(map, seen, COUNT);
}

static void what_moved_by_whole_pixels_does_not_flicker(void **state)
{
    (void)state;
    fill_wall(&before, 0, 0);
    fill_wall(&now, 3, -2);
    /* three columns came in at the left, two rows at the bottom */
    assert_int_equal(reproject(), (WIDTH - 3) * (HEIGHT - 2));
    assert_memory_equal(moved, now.rgb, sizeof moved);
    assert_true(flicker() == 0);
}

/* Cubics pass through straight lines; a check is gone half-way between its fields. */
static void parts_of_pixels_are_interpolated(void **state)
{
    (void)state;
    fill_wall(&before, 0, 0);
    fill_wall(&now, 0.5f, 0);
    assert_int_equal(reproject(), (WIDTH - 1) * HEIGHT);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 2; x < WIDTH - 1; x++) {
            const float *p = moved + (y * WIDTH + x) * 3;
            assert_true(fabsf(p[0] - now.rgb[(y * WIDTH + x) * 3]) < 1e-6f);
            assert_true(fabsf(p[1] - now.rgb[(y * WIDTH + x) * 3 + 1]) < 1e-6f);
            assert_true(fabsf(p[2] - 0.5f) < 1e-6f);
        }
}

/* A box stands before the wall and goes four pixels to the right: the four columns that it uncovers were
 * hidden, and it is found again itself. Its picture is black. */
static void what_was_hidden_does_not_count(void **state)
{
    (void)state;
    fill_wall(&before, 0, 0);
    fill_wall(&now, 0, 0);
    for (int frame = 0; frame < 2; frame++) {
        scene *s = frame ? &now : &before;
        for (int i = 0; i < COUNT; i++) {
            int x = i % WIDTH - 4 * frame;
            if (x < 10 || x >= 20)
                continue;
            s->depth[i] = 4;
            s->motion[0][i] = -4;
            memset(s->rgb + i * 3, 0, 3 * sizeof *s->rgb);
        }
    }
    assert_int_equal(reproject(), COUNT - 4 * HEIGHT);
    for (int i = 0; i < COUNT; i++)
        assert_int_equal(seen[i], i % WIDTH < 10 || i % WIDTH >= 14);
    assert_true(flicker() == 0);
}

/* A surface that turned by a right angle is another one, and so is the background. */
static void another_surface_is_not_taken(void **state)
{
    (void)state;
    fill_wall(&before, 0, 0);
    fill_wall(&now, 0, 0);
    before.normal[2][0] = 0;
    before.normal[0][0] = 1;
    before.depth[1] = 1e10f;
    now.depth[2] = 1e10f;
    before.depth[3] = now.depth[3] = 1e10f;
    assert_int_equal(reproject(), COUNT - 3);
    assert_true(!seen[0] && !seen[1] && !seen[2] && seen[3]);
}

/* Two greys all over: the difference of flat pictures, as compare_metrics derives it, whatever part was
 * hidden. */
static void a_flicker_has_the_value_of_its_colours(void **state)
{
    (void)state;
    fill_wall(&before, 0, 0);
    fill_wall(&now, 0, 0);
    for (int i = 0; i < COUNT * 3; i++) {
        before.rgb[i] = 0.5f;
        now.rgb[i] = 0.4f;
    }
    double expected = 0.95 / (0.4 * pow(203.31, 0.7)) * pow(53.389 - 43.192, 0.7);
    assert_int_equal(reproject(), COUNT);
    assert_true(fabs(flicker() - expected) < 1e-4);
    /* the upper half comes from elsewhere: it counts no more, and near to it what is seen is blurred with it
     */
    for (int i = 0; i < COUNT / 2; i++)
        now.motion[1][i] = -HEIGHT;
    assert_int_equal(reproject(), COUNT / 2);
    assert_true(fabs(flicker() - expected) < 0.2 * expected);
}

static void nothing_seen_again_is_no_difference(void **state)
{
    (void)state;
    fill_wall(&before, 0, 0);
    fill_wall(&now, 0, 0);
    for (int i = 0; i < COUNT; i++)
        now.motion[0][i] = 1e4f;
    assert_int_equal(reproject(), 0);
    assert_true(flicker() == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_moved_by_whole_pixels_does_not_flicker),
        cmocka_unit_test(parts_of_pixels_are_interpolated),
        cmocka_unit_test(what_was_hidden_does_not_count),
        cmocka_unit_test(another_surface_is_not_taken),
        cmocka_unit_test(a_flicker_has_the_value_of_its_colours),
        cmocka_unit_test(nothing_seen_again_is_no_difference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
