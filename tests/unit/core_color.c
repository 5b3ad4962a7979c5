#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/core/color.h"

static void codes_survive_decoding_and_encoding(void **state)
{
    (void)state;
    for (int code = 0; code < 256; code++) {
        assert_int_equal(kd_color_byte(kd_color_srgb_encode(kd_color_from_srgb8[code])), code);
        assert_true(fabsf(kd_color_srgb_decode((float)code / 255) - kd_color_from_srgb8[code]) < 1e-6f);
    }
}

/* ACES at x = 0.6 c: x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), c = 1: 0.9216 / 1.3688 = 0.67328. */
static void curves_give_their_formulas(void **state)
{
    (void)state;
    kd_vec3 one = {1, 1, 1}, half = {0.5f, 0.5f, 0.5f};
    assert_true(fabsf(kd_color_screen(one, 1, KD_TONEMAP_ACES).x - kd_color_srgb_encode(0.67328f)) < 1e-4f);
    assert_true(fabsf(kd_color_screen(half, 2, KD_TONEMAP_ACES).y -
                      kd_color_screen(one, 1, KD_TONEMAP_ACES).y) < 1e-6f);
    assert_true(fabsf(kd_color_screen(one, 1, KD_TONEMAP_REINHARD).z - kd_color_srgb_encode(0.5f)) < 1e-6f);
    assert_true(fabsf(kd_color_screen(one, 1, KD_TONEMAP_LINEAR).x - 1) < 1e-6f);
}

static void any_radiance_becomes_a_code(void **state)
{
    (void)state;
    const float values[] = {0, -1, 1e6f, 1e30f, INFINITY, NAN};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        for (int curve = KD_TONEMAP_ACES; curve <= KD_TONEMAP_LINEAR; curve++) {
            kd_vec3 c = kd_color_screen((kd_vec3){values[i], values[i], values[i]}, 1, (kd_tonemap)curve);
            assert_true(c.x >= 0 && c.x <= 1);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_survive_decoding_and_encoding),
        cmocka_unit_test(curves_give_their_formulas),
        cmocka_unit_test(any_radiance_becomes_a_code),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
