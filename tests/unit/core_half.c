#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/core/half.h"

static void every_half_survives_the_way_there_and_back(void **state)
{
    (void)state;
    for (uint32_t h = 0; h < 0x10000; h++) {
        bool finite = (h & 0x7c00) != 0x7c00;
        if (finite)
            assert_int_equal(kd_half_from_float(kd_half_to_float((uint16_t)h)), h);
    }
}

/* Halfs near 1 are 2^-10 apart: 1 + 2^-11 lies in the middle and goes to the even one, 1; the next float
 * above goes up. */
static void rounding_is_to_nearest_even(void **state)
{
    (void)state;
    assert_int_equal(kd_half_from_float(1 + ldexpf(1, -11)), 0x3c00);
    assert_int_equal(kd_half_from_float(nextafterf(1 + ldexpf(1, -11), 2)), 0x3c01);
    assert_int_equal(kd_half_from_float(1 + ldexpf(3, -11)), 0x3c02);
    assert_int_equal(kd_half_from_float(ldexpf(1, -25)), 0);
    assert_int_equal(kd_half_from_float(ldexpf(3, -25)), 2);
}

static void what_does_not_fit_is_clamped(void **state)
{
    (void)state;
    assert_true(kd_half_to_float(kd_half_from_float(1e9f)) == 65504);
    assert_true(kd_half_to_float(kd_half_from_float(INFINITY)) == 65504);
    assert_true(kd_half_to_float(kd_half_from_float(-65510)) == -65504);
    assert_int_equal(kd_half_from_float(NAN), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_half_survives_the_way_there_and_back),
        cmocka_unit_test(rounding_is_to_nearest_even),
        cmocka_unit_test(what_does_not_fit_is_clamped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
