#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/core/ranges.h"

static void take_gives_the_lowest_place_that_is_large_enough(void **state)
{
    (void)state;
    kd_ranges r = {0};
    assert_int_equal(kd_ranges_take(&r, 10), 0);
    assert_int_equal(kd_ranges_take(&r, 5), 10);
    assert_int_equal(kd_ranges_take(&r, 7), 15);
    assert_true(kd_ranges_give(&r, 0, 10));
    assert_int_equal(kd_ranges_bound(&r, 11), 22 + 11);
    assert_int_equal(kd_ranges_take(&r, 11), 22); /* no hole holds it */
    assert_int_equal(kd_ranges_bound(&r, 4), 33);
    assert_int_equal(kd_ranges_take(&r, 4), 0);
    assert_int_equal(kd_ranges_take(&r, 6), 4);
    assert_int_equal(r.hole_count, 0);
    assert_int_equal(kd_ranges_taken(&r), 33);
    kd_ranges_fini(&r);
}

static void end_goes_back_over_holes_that_touch_it(void **state)
{
    (void)state;
    kd_ranges r = {0};
    for (int i = 0; i < 4; i++)
        kd_ranges_take(&r, 8);
    assert_true(kd_ranges_give(&r, 16, 8));
    assert_true(kd_ranges_give(&r, 8, 8));
    assert_int_equal(r.hole_count, 1);
    assert_true(kd_ranges_give(&r, 24, 8));
    assert_int_equal(r.end, 8);
    assert_int_equal(r.hole_count, 0);
    assert_int_equal(r.free_count, 0);
    kd_ranges_fini(&r);
}

static void numbers_beyond_the_last_are_refused(void **state)
{
    (void)state;
    kd_ranges r = {0};
    assert_int_equal(kd_ranges_take(&r, UINT32_MAX - 1), 0);
    assert_int_equal(kd_ranges_take(&r, 2), UINT32_MAX);
    assert_int_equal(r.end, UINT32_MAX - 1);
    kd_ranges_fini(&r);
}

/* Against a map of what is taken: nothing is given out twice, and what is free is known to be. */
static void random_taking_and_giving_keeps_the_books(void **state)
{
    (void)state;
    enum { ROUNDS = 20000, LIVE = 64, MOST = 4096 };
    static uint8_t taken[MOST];
    kd_range live[LIVE] = {{0, 0}};
    kd_ranges r = {0};
    uint64_t random = 7, sum = 0;
    for (int i = 0; i < ROUNDS; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        kd_range *one = &live[random >> 40 & (LIVE - 1)];
        if (one->count) {
            assert_true(kd_ranges_give(&r, one->first, one->count));
            memset(taken + one->first, 0, one->count);
            sum -= one->count;
            one->count = 0;
        } else {
            one->count = 1 + (uint32_t)(random >> 50 & 31);
            one->first = kd_ranges_take(&r, one->count);
            assert_true(one->first + one->count <= MOST);
            for (uint32_t n = 0; n < one->count; n++)
                assert_int_equal(taken[one->first + n]++, 0);
            sum += one->count;
        }
        assert_int_equal(kd_ranges_taken(&r), sum);
        assert_true(r.end == 0 || taken[r.end - 1]);
        for (uint32_t h = 0; h < r.hole_count; h++)
            assert_true(r.holes[h].count && !taken[r.holes[h].first] &&
                        taken[r.holes[h].first + r.holes[h].count]);
    }
    kd_ranges_fini(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(take_gives_the_lowest_place_that_is_large_enough),
        cmocka_unit_test(end_goes_back_over_holes_that_touch_it),
        cmocka_unit_test(numbers_beyond_the_last_are_refused),
        cmocka_unit_test(random_taking_and_giving_keeps_the_books),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
