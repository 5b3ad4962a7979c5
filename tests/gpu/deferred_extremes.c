/* Lights and materials at the ends of their ranges: every value of the picture is a number, and not below 0.
 */

#include "tests/render_fixture.h"

static void add_box(render *r, const kd_material_desc *m, kd_vec3 position)
{
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, m, position, RENDER_UPRIGHT, RENDER_UNIT);
}

static void add_surfaces(render *r)
{
    kd_material_desc white = render_matte(1), black = render_matte(0), mirror = render_matte(1);
    mirror.metallic = 1;
    mirror.roughness = 0;
    add_box(r, &white, (kd_vec3){0, -0.5f, 0});
    add_box(r, &black, (kd_vec3){-1.1f, 0, 0});
    add_box(r, &mirror, (kd_vec3){1.1f, 0, 0});
    mirror.alpha_mode = KD_ALPHA_BLEND;
    mirror.base_color.w = 0.5f;
    add_box(r, &mirror, (kd_vec3){0, 0, 1.1f});
}

/* In a wall, on a surface, dark, blinding, without reach, with a cone that ends where it begins or before. */
static void add_lights(render *r)
{
    const kd_light lamp = {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 1e6f};
    kd_light spot = {
        .type = KD_SPOT, .color = {1, 1, 1}, .intensity = 5, .inner_cone = 0.5f, .outer_cone = 0.5f};
    const kd_vec3 down = {0, -1, 0};
    render_light(r, lamp, (kd_vec3){0, -0.5f, 0}, down);
    render_light(r, lamp, (kd_vec3){0, 0, 0}, down);
    render_light(r, (kd_light){.type = KD_POINT, .intensity = 0}, (kd_vec3){0, 1, 0}, down);
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = 3, .range = 1e-6f},
                 (kd_vec3){0, 0.1f, 0}, down);
    render_light(r, spot, (kd_vec3){0, 3, 0}, down);
    spot.inner_cone = 1.5707964f;
    spot.outer_cone = 0;
    render_light(r, spot, (kd_vec3){1, 3, 0}, down);
    for (int i = 0; i < KD_MAX_LIGHTS; i++)
        render_light(r,
                     (kd_light){.type = i % 50 == 0 ? KD_DIRECTIONAL : KD_POINT,
                                .color = {1, 1, 1},
                                .intensity = 0.01f,
                                .no_shadow = i % 10 != 0},
                     (kd_vec3){0.01f * (float)i, 2, 0}, (kd_vec3){0.01f * (float)i, -1, 0});
}

static float expect_numbers(render *r, const char *name)
{
    render_frame(r, name);
    float brightest = 0;
    for (size_t i = 0; i < (size_t)r->frame->width * r->frame->height * 4; i++) {
        if (!(r->hdr[i] >= 0 && r->hdr[i] <= 65504))
            fail_msg("%s: value %zu is %g", name, i, (double)r->hdr[i]);
        brightest = fmaxf(brightest, r->hdr[i]);
    }
    return brightest;
}

static void extremes_give_numbers(void **state)
{
    render *r = *state;
    add_surfaces(r);
    add_lights(r);
    kd_entity camera = render_camera(r, (kd_vec3){0, 2, 4}, (kd_vec3){0, 0, 0}, 0.8f);
    assert_true(expect_numbers(r, "outside") > 1000);
    kd_find_mut(r->world, camera, kd_transform)->position =
        (kd_vec3){1.1f, 0, 0.1f}; /* in the mirror's box */
    expect_numbers(r, "inside");  /* which sees no backs, and so perhaps nothing */
    r->frame->settings.view_auto_exposure = true;
    expect_numbers(r, "measured");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(extremes_give_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
