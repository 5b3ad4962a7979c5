/* What is blended casts the shadow of its parts that are more than half opaque. */

#include "tests/render_fixture.h"

/* Light on a floor, seen from above, where a pane a metre up throws its shadow: the light comes at 45 degrees
 * from the left. */
static float light_behind(render *r, float opacity, float transmission)
{
    kd_material_desc floor = render_matte(0.5f), pane = render_matte(0.5f);
    const kd_light sun = {.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3};
    pane.alpha_mode = KD_ALPHA_BLEND;
    pane.base_color.w = opacity;
    pane.transmission = transmission;
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){20, 0.1f, 20}, &floor, (kd_vec3){0, -0.05f, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){0.6f, 0.02f, 0.6f}, &pane, (kd_vec3){-0.5f, 1, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_light(r, sun, (kd_vec3){0, 0, 0}, (kd_vec3){1, -1, 0});
    render_top_camera(r, 2);
    render_frame(r, "blended");
    assert_true(render_pixel(r, 80 + 15, 60 - 30)[0] > 0.2f); /* beside the shadow */
    return render_pixel(r, 80 + 15, 60)[0];
}

static void cloth_throws_a_shadow(void **state)
{
    assert_true(light_behind(*state, 0.8f, 0) < 0.01f);
}

static void thin_veils_throw_none(void **state)
{
    assert_true(light_behind(*state, 0.3f, 0) > 0.2f);
}

static void glass_throws_none(void **state)
{
    assert_true(light_behind(*state, 1, 0.9f) > 0.2f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(cloth_throws_a_shadow),
        RENDER_TEST(thin_veils_throw_none),
        RENDER_TEST(glass_throws_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
