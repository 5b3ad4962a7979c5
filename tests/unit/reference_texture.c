/* Maps read as a sampler of OpenGL reads them at its finest level. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/reference/internal.h"

/* Four texels: 0, 51, 102, 255 in red; linear, so 0, 0.2, 0.4, 1. */
static const uint8_t texels[16] = {0, 0, 0, 255, 51, 0, 0, 255, 102, 0, 0, 255, 255, 0, 0, 255};
static const kd_image row = {"row", 4, 1, texels};

static reference_material material_of(kd_wrap_mode wrap, bool nearest)
{
    reference_material m = {
        .params = {.base_color = {1, 1, 1, 1}, .uv_transform = {{1, 0, 0, 0}, {0, 1, 0, 0}}}};
    m.maps[0] = (reference_map){.image = &row, .wrap_s = wrap, .wrap_t = wrap, .nearest = nearest};
    return m;
}

static void expect(const reference_material *m, float u, float red)
{
    reference_attributes a = {.uv = {{u, 0.5f}}, .color = {1, 1, 1, 1}};
    float got = reference_base_color(m, &a).x;
    if (!(fabsf(got - red) < 1e-5f))
        fail_msg("%g at %g, expected %g", (double)got, (double)u, (double)red);
}

static void texels_are_met_at_their_middles(void **state)
{
    (void)state;
    const float values[4] = {0, 0.2f, 0.4f, 1};
    for (int wrap = KD_WRAP_REPEAT; wrap <= KD_WRAP_MIRROR; wrap++)
        for (int nearest = 0; nearest < 2; nearest++) {
            reference_material m = material_of((kd_wrap_mode)wrap, nearest);
            for (int i = 0; i < 4; i++)
                expect(&m, ((float)i + 0.5f) / 4, values[i]);
        }
}

/* Beyond the border: 1 + 1/8 is the first texel again, the last, or the last (mirrored); -1/8 the last, the
 * first, the first. Far out the same; in between, means. */
static void borders_wrap_as_asked(void **state)
{
    (void)state;
    reference_material repeat = material_of(KD_WRAP_REPEAT, false), clamp = material_of(KD_WRAP_CLAMP, false),
                       mirror = material_of(KD_WRAP_MIRROR, false);
    expect(&repeat, 1.125f, 0);
    expect(&repeat, -0.125f, 1);
    expect(&repeat, 0, 0.5f);
    expect(&repeat, 1, 0.5f);
    expect(&repeat, -7 + 0.375f, 0.2f);
    expect(&clamp, 1.125f, 1);
    expect(&clamp, -0.125f, 0);
    expect(&clamp, 30, 1);
    expect(&clamp, 0.25f, 0.1f);
    expect(&mirror, 1.125f, 1);
    expect(&mirror, -0.125f, 0);
    expect(&mirror, 2.375f, 0.2f);
    expect(&mirror, 1, 1);
}

static void coordinates_of_any_kind_are_harmless(void **state)
{
    (void)state;
    const float odd[] = {INFINITY, -INFINITY, NAN, 1e30f, -1e30f, 3e9f};
    for (int wrap = KD_WRAP_REPEAT; wrap <= KD_WRAP_MIRROR; wrap++)
        for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
            reference_material m = material_of((kd_wrap_mode)wrap, i & 1);
            reference_attributes a = {.uv = {{odd[i], odd[i]}}, .color = {1, 1, 1, 1}};
            float got = reference_base_color(&m, &a).x;
            assert_true(got >= 0 && got <= 1);
        }
}

/* Codes 0 and 255 in one half each: light's mean is 0.5; that of the codes is decoded to 0.214. */
static void codes_are_decoded_before_they_are_mixed_or_after(void **state)
{
    (void)state;
    static const uint8_t two[8] = {0, 0, 0, 255, 255, 0, 0, 255};
    const kd_image pair = {"pair", 2, 1, two};
    reference_material m = material_of(KD_WRAP_CLAMP, false);
    m.maps[0].image = &pair;
    m.maps[0].srgb = true;
    expect(&m, 0.5f, 0.5f);
    m.maps[0].late_decode = true;
    expect(&m, 0.5f, 0.2140411f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_are_met_at_their_middles),
        cmocka_unit_test(borders_wrap_as_asked),
        cmocka_unit_test(coordinates_of_any_kind_are_harmless),
        cmocka_unit_test(codes_are_decoded_before_they_are_mixed_or_after),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
