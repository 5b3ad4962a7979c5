/* What the header of vectors and matrices computes beyond single lines. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/core/math.h"

static float stretch_of(const kd_mat4 *m)
{
    return kd_mat3_stretch((kd_vec3){m->m[0], m->m[1], m->m[2]}, (kd_vec3){m->m[4], m->m[5], m->m[6]},
                           (kd_vec3){m->m[8], m->m[9], m->m[10]});
}

/* A turn, a scale by axes and another turn: the largest scale is what a vector can gain, however the columns
 * of the product lie. */
static void stretch_is_the_largest_scale_whatever_turns(void **state)
{
    (void)state;
    static const kd_vec3 scales[] = {{1, 1, 1},     {2, 0.5f, 0.7f}, {-3, 1, 2},
                                     {1, 1, 1e-4f}, {5, 5, 0.1f},    {1e-3f, 2e-3f, 1e-3f}};
    const kd_quat turns[] = {{0, 0, 0, 1}, {0.5f, 0.5f, 0.5f, 0.5f}, {0.36f, 0.48f, 0, 0.8f}};
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++)
        for (int i = 0; i < 9; i++) {
            kd_vec3 none = {0, 0, 0}, one = {1, 1, 1}, by = scales[s];
            kd_mat4 a = kd_mat4_from_trs(none, turns[i / 3], by),
                    b = kd_mat4_from_trs(none, turns[i % 3], one);
            kd_mat4 m = kd_mat4_mul(&a, &b);
            float most = fmaxf(fabsf(by.x), fmaxf(fabsf(by.y), fabsf(by.z)));
            assert_float_equal(stretch_of(&m) / most, 1, 2e-4f);
        }
}

static void stretch_of_right_angles_is_exact(void **state)
{
    (void)state;
    kd_mat4 turned =
        kd_mat4_from_trs((kd_vec3){1, 2, 3}, (kd_quat){0.5f, 0.5f, 0.5f, 0.5f}, (kd_vec3){1, 1, 1});
    kd_mat4 zero = {{0}}, identity = KD_MAT4_IDENTITY;
    assert_true(stretch_of(&turned) == 1);
    assert_true(stretch_of(&identity) == 1);
    assert_true(stretch_of(&zero) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stretch_is_the_largest_scale_whatever_turns),
        cmocka_unit_test(stretch_of_right_angles_is_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
