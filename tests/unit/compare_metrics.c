/* FLIP, relMSE and SSIM: what their papers promise, and pairs whose value can be had by hand. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/compare/compare.h"

enum { SIDE = 48, COUNT = SIDE * SIDE };

static float a[COUNT * 3], b[COUNT * 3], map[COUNT], other[COUNT];

static void fill(float *p, float red, float green, float blue)
{
    for (size_t i = 0; i < COUNT; i++) {
        p[i * 3] = red;
        p[i * 3 + 1] = green;
        p[i * 3 + 2] = blue;
    }
}

/* Source  Steele, Lea, Flood 2014, SplitMix64 */
static float random_unit(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return (float)((z ^ z >> 31) >> 40) / 16777216.0f;
}

static void fill_random(float *p, uint64_t seed)
{
    for (size_t i = 0; i < COUNT * 3; i++)
        p[i] = random_unit(&seed);
}

static double flip(const float *x, const float *y)
{
    double mean;
    assert_int_equal(kd_flip_ldr(x, y, SIDE, SIDE, 0, map, &mean), KD_OK);
    return mean;
}

static double flip_hdr(const float *test, const float *reference)
{
    kd_flip_exposures e;
    double mean;
    assert_int_equal(kd_flip_exposures_of(reference, SIDE, SIDE, &e), KD_OK);
    assert_int_equal(kd_flip_hdr(test, reference, SIDE, SIDE, 0, &e, map, &mean), KD_OK);
    return mean;
}

static void expect(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g is not within %g of %.9g", value, tolerance, expected);
}

static void flip_of_equal_pictures_is_zero(void **state)
{
    (void)state;
    fill_random(a, 1);
    assert_true(flip(a, a) == 0);
    assert_true(flip_hdr(a, a) == 0);
    fill(a, 0, 0, 0);
    assert_true(flip(a, a) == 0);
    assert_true(flip_hdr(a, a) == 0);
}

static void flip_is_symmetric(void **state)
{
    (void)state;
    fill_random(a, 2);
    fill_random(b, 3);
    double forth = flip(a, b);
    memcpy(other, map, sizeof map);
    expect(flip(b, a), forth, 1e-7);
    for (size_t i = 0; i < COUNT; i++)
        expect((double)map[i], (double)other[i], 1e-6);
    assert_true(forth > 0.1 && forth < 1);
}

/* Flat pictures have no features and are not changed by blurring, so FLIP is the colour difference alone. The
 * green and blue primaries are the pair that differs most by definition: 1. White and black are 100 apart in
 * lightness: with c the greatest difference to the power 0.7 and d = 100^0.7, 0.95 + 0.05 (d - 0.4 c) / (0.6
 * c); c is of HyAB 203.31 between (87.735, -75.61, 72.98) and (32.301, 25.58, -34.84). */
static void flip_of_flat_pairs_is_their_colour_difference(void **state)
{
    (void)state;
    fill(a, 0, 1, 0);
    fill(b, 0, 0, 1);
    expect(flip(a, b), 1, 1e-4);
    fill(a, 1, 1, 1);
    fill(b, 0, 0, 0);
    double c = pow(55.434 + hypot(101.19, 107.82), 0.7), d = pow(100, 0.7);
    expect(flip(a, b), 0.95 + 0.05 * (d - 0.4 * c) / (0.6 * c), 1e-4);
    /* Two greys on the straight part: lightness of code 0.5 is 53.389, of 0.4 43.192. */
    fill(a, 0.5f, 0.5f, 0.5f);
    fill(b, 0.4f, 0.4f, 0.4f);
    expect(flip(a, b), 0.95 / (0.4 * c) * pow(53.389 - 43.192, 0.7), 1e-4);
}

/* Fine checks of one pixel blur to the same grey; coarse ones are seen. */
static void flip_sees_coarse_patterns_rather_than_fine_ones(void **state)
{
    double means[2];
    (void)state;
    for (int coarse = 0; coarse < 2; coarse++) {
        for (size_t i = 0; i < COUNT; i++) {
            size_t x = i % SIDE, y = i / SIDE, size = coarse ? 12 : 1;
            float on = ((x / size + y / size) & 1) ? 0.6f : 0.4f;
            for (size_t k = 0; k < 3; k++) {
                a[i * 3 + k] = on;
                b[i * 3 + k] = 1 - on;
            }
        }
        means[coarse] = flip(a, b);
    }
    assert_true(means[0] < 0.5 * means[1]);
}

/* A dot on a plain ground is a feature: it counts for more than its colour where it stands, and not at all
 * elsewhere. */
static void flip_raises_what_is_a_feature(void **state)
{
    (void)state;
    fill(a, 0.5f, 0.5f, 0.5f);
    memcpy(b, a, sizeof b);
    size_t middle = (SIDE / 2) * SIDE + SIDE / 2;
    for (size_t k = 0; k < 3; k++)
        b[middle * 3 + k] = 1;
    assert_true(flip(a, b) > 0);
    assert_true(map[middle] > 0.2f);
    assert_true(map[0] == 0);
}

static void flip_depends_on_the_distance_of_the_viewer(void **state)
{
    double near, far;
    (void)state;
    fill_random(a, 5);
    fill_random(b, 6);
    assert_int_equal(kd_flip_ldr(a, b, SIDE, SIDE, 30, NULL, &near), KD_OK);
    assert_int_equal(kd_flip_ldr(a, b, SIDE, SIDE, 120, NULL, &far), KD_OK);
    assert_true(far < near);
}

/* A picture of one brightness is looked at with that near white: x = 0.85 of the curve is at 1.6906 of its
 * input, so start and stop are log2 of that, and there are two. Twice as bright a picture moves both by one.
 */
static void exposures_follow_the_reference(void **state)
{
    kd_flip_exposures one, two;
    (void)state;
    fill(a, 1, 1, 1);
    fill(b, 2, 2, 2);
    assert_int_equal(kd_flip_exposures_of(a, SIDE, SIDE, &one), KD_OK);
    assert_int_equal(kd_flip_exposures_of(b, SIDE, SIDE, &two), KD_OK);
    double x = exp2((double)one.start_ev) * 0.6;
    expect(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.85, 1e-5);
    expect((double)one.stop_ev, (double)one.start_ev, 1e-6);
    expect((double)two.start_ev, (double)one.start_ev - 1, 1e-6);
    assert_int_equal(one.count, 2);
    b[0] = b[1] = b[2] = 2 * 1024; /* brightest ten stops above the median: ten exposures */
    assert_int_equal(kd_flip_exposures_of(b, SIDE, SIDE, &two), KD_OK);
    assert_int_equal(two.count, 10);
}

static void hdr_flip_finds_what_one_exposure_hides(void **state)
{
    (void)state;
    fill(a, 0.2f, 0.2f, 0.2f);
    fill(b, 0.2f, 0.2f, 0.2f);
    for (size_t i = 0; i < COUNT / 4 * 3; i++) { /* far above white, and twice that */
        a[i] = 500;
        b[i] = 1000;
    }
    assert_true(flip_hdr(a, b) > 0.05);
}

/* (1.1 r - r)^2 / (r^2 + 0.01) with r = 1: 0.01 / 1.01. */
static void relative_mse_is_its_formula(void **state)
{
    (void)state;
    fill(a, 1.1f, 1.1f, 1.1f);
    fill(b, 1, 1, 1);
    expect(kd_relative_mse(a, b, SIDE, SIDE), 0.01 / 1.01, 1e-6);
    assert_true(kd_relative_mse(b, b, SIDE, SIDE) == 0);
    fill(b, 0, 0, 0);
    expect(kd_relative_mse(a, b, SIDE, SIDE), 1.21 / 0.01, 1e-3);
}

/* Flat pictures: (2 m n + c) / (m^2 + n^2 + c) with c = 1e-4. */
static void ssim_of_flat_pictures_compares_their_means(void **state)
{
    double value;
    (void)state;
    fill_random(a, 9);
    assert_int_equal(kd_ssim(a, a, SIDE, SIDE, &value), KD_OK);
    expect(value, 1, 1e-6);
    fill(a, 0.5f, 0.5f, 0.5f);
    fill(b, 0.25f, 0.25f, 0.25f);
    assert_int_equal(kd_ssim(a, b, SIDE, SIDE, &value), KD_OK);
    expect(value, (2 * 0.125 + 1e-4) / (0.3125 + 1e-4), 1e-4);
}

static void ssim_of_unlike_noise_is_low(void **state)
{
    double value;
    (void)state;
    fill_random(a, 10);
    fill_random(b, 11);
    assert_int_equal(kd_ssim(a, b, SIDE, SIDE, &value), KD_OK);
    assert_true(value < 0.2);
}

static void small_pictures_are_measured_too(void **state)
{
    double mean;
    (void)state;
    float x[3] = {1, 1, 1}, y[3] = {0, 0, 0};
    assert_int_equal(kd_flip_ldr(x, y, 1, 1, 0, NULL, &mean), KD_OK);
    assert_true(mean > 0.9);
    assert_int_equal(kd_ssim(x, y, 1, 1, &mean), KD_OK);
    assert_true(mean < 0.1);
}

static void heat_rises_in_brightness(void **state)
{
    float last = -1, rgb[3];
    (void)state;
    for (int i = 0; i <= 100; i++) {
        kd_heat_color((float)i / 100, rgb);
        float y = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
        assert_true(y > last);
        last = y;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flip_of_equal_pictures_is_zero),
        cmocka_unit_test(flip_is_symmetric),
        cmocka_unit_test(flip_of_flat_pairs_is_their_colour_difference),
        cmocka_unit_test(flip_sees_coarse_patterns_rather_than_fine_ones),
        cmocka_unit_test(flip_raises_what_is_a_feature),
        cmocka_unit_test(flip_depends_on_the_distance_of_the_viewer),
        cmocka_unit_test(exposures_follow_the_reference),
        cmocka_unit_test(hdr_flip_finds_what_one_exposure_hides),
        cmocka_unit_test(relative_mse_is_its_formula),
        cmocka_unit_test(ssim_of_flat_pictures_compares_their_means),
        cmocka_unit_test(ssim_of_unlike_noise_is_low),
        cmocka_unit_test(small_pictures_are_measured_too),
        cmocka_unit_test(heat_rises_in_brightness),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
