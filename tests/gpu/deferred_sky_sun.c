/* The sun in a sky's picture lights as a directional light does: with shadows, turned with the sky. */

#include "components/sky.h"
#include "tests/render_fixture.h"

enum { WIDTH = 256, HEIGHT = 128 };
static const float PI = 3.14159265f;

/* A black sky with a sun of 1 W/m² straight along -Z of the picture, 45 degrees high, and so bright a factor.
 */
static kd_entity add_sky(render *r, kd_quat rotation, float factor)
{
    float *rgb = calloc(WIDTH * HEIGHT * 3, sizeof *rgb);
    assert_non_null(rgb);
    uint32_t y = HEIGHT / 4, x = WIDTH / 2;
    float polar = PI * ((float)y + 0.5f) / HEIGHT, texel = sinf(polar) * (PI / HEIGHT) * (2 * PI / WIDTH);
    for (int k = 0; k < 3; k++) /* on both sides of the middle */
        rgb[(y * WIDTH + x) * 3 + (uint32_t)k] = rgb[(y * WIDTH + x - 1) * 3 + (uint32_t)k] = 0.5f / texel;
    kd_sky sky = {.intensity = factor, .image = kd_sky_add_image(r->world, (kd_sky_map){WIDTH, HEIGHT, rgb})};
    assert_true(sky.image > 0);
    kd_sky_find_sun(r->world, sky.image);
    return kd_spawn(r->world, (kd_value){&kd_sky_desc, &sky},
                    KD_VAL(kd_transform, {{0, 0, 0}, rotation, {1, 1, 1}}), KD_TAG(kd_world_transform));
}

/* Seen from above, 2 m up and down, 2.67 to the sides: pixel of a place on the floor. */
static const float *floor_at(const render *r, float x, float z)
{
    return render_pixel(r, (uint32_t)(80 + 30 * x), (uint32_t)(60 + 30 * z));
}

static void set_up(render *r)
{
    kd_material_desc m = render_matte(0.5f);
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){20, 0.1f, 20}, &m, (kd_vec3){0, -0.05f, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){0.6f, 1, 0.6f}, &m, (kd_vec3){0, 0.5f, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_top_camera(r, 2);
}

/* Irradiance of 3 at 45 degrees on an albedo of a half (polar angle of the texels' middle 45.7 degrees); the
 * material's reflection at its full roughness takes and adds a few hundredths. A box of 1 m throws a shadow
 * of 1 m away from the sun. */
static void sun_throws_shadows(void **state)
{
    render *r = *state;
    set_up(r);
    add_sky(r, RENDER_UPRIGHT, 3);
    render_frame(r, "sun");
    float lit = floor_at(r, 1.2f, 0)[0], expected = 3 * cosf(45.7f * PI / 180) * 0.5f / PI;
    assert_true(fabsf(lit - expected) < 0.08f * expected);
    assert_true(floor_at(r, 0, 0.7f)[0] < 0.02f * lit);
    assert_true(floor_at(r, 0, -0.7f)[0] > 0.95f * lit);
    assert_true(floor_at(r, 0, 1.6f)[0] > 0.95f * lit);
}

/* Turned by 90 degrees about y, what was along -Z lies along -X: the shadow falls towards +X. Without the
 * setting the light stays in the picture, whose means have no shadows. */
static void sun_turns_with_its_sky_and_can_be_left_in_it(void **state)
{
    render *r = *state;
    set_up(r);
    add_sky(r, (kd_quat){0, sqrtf(0.5f), 0, sqrtf(0.5f)}, 3);
    render_frame(r, "turned");
    float lit = floor_at(r, 0, 1.2f)[0];
    assert_true(lit > 0.3f);
    assert_true(floor_at(r, 0.7f, 0)[0] < 0.02f * lit);
    assert_true(floor_at(r, -0.7f, 0)[0] > 0.95f * lit);
    r->frame->settings.light_sky_sun = false;
    render_frame(r, "left in");
    float even = floor_at(r, 0.7f, 0)[0];
    assert_true(even > 0.1f && fabsf(even - floor_at(r, 0, 1.2f)[0]) < 0.01f * even);
    r->frame->settings.light_sky_sun = true;
    render_frame(r, "turned again");
    assert_true(floor_at(r, 0.7f, 0)[0] < 0.02f * lit);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(sun_throws_shadows),
        RENDER_TEST(sun_turns_with_its_sky_and_can_be_left_in_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
