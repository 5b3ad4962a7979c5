/* Light of skies: a plane's radiance against sums over the picture. */

#include "components/sky.h"
#include "tests/reference_fixture.h"

enum { WIDTH = 64, HEIGHT = 32 };

static kd_entity add_sky(fixture *f, const float *rgb, kd_quat rotation)
{
    float *copy = malloc(WIDTH * HEIGHT * 3 * sizeof *copy);
    assert_non_null(copy);
    memcpy(copy, rgb, WIDTH * HEIGHT * 3 * sizeof *copy);
    kd_sky sky = {.intensity = 2, .image = kd_sky_add_image(f->world, (kd_sky_map){WIDTH, HEIGHT, copy})};
    assert_true(sky.image > 0);
    return kd_spawn(f->world, (kd_value){&kd_sky_desc, &sky},
                    KD_VAL(kd_transform, {{0, 0, 0}, rotation, {1, 1, 1}}), KD_TAG(kd_world_transform));
}

static void look_at_plane(fixture *f, float albedo)
{
    kd_material_desc m = fixture_material(albedo, 0, 1);
    f->desc.lambert = true;
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &m, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){0, 3, 0}, (kd_vec3){0, 0, 0});
}

/* A picture of 0.5 all round, twice as bright by its factor, is a uniform sky of 1: the plane has its albedo.
 */
static void uniform_picture_is_a_uniform_sky(void **state)
{
    fixture *f = *state;
    static float rgb[WIDTH * HEIGHT * 3];
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        rgb[i] = 0.5f;
    look_at_plane(f, 0.6f);
    add_sky(f, rgb, (kd_quat){0, 0, 0, 1});
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 0.6, 0.005);
}

/* Irradiance on a plane with its normal along `up` of the picture's own space, over pi: midpoints of 16 x 16
 * cells in each texel. */
static double plane_sum(const kd_sky_map *map, kd_vec3 up)
{
    const int cells = 16;
    double sum = 0, step = 1.0 / (HEIGHT * cells);
    for (int y = 0; y < HEIGHT * cells; y++)
        for (int x = 0; x < WIDTH * cells; x++) {
            kd_vec2 place = {((float)x + 0.5f) / (float)(WIDTH * cells),
                             ((float)y + 0.5f) / (float)(HEIGHT * cells)};
            kd_vec3 d = kd_sky_direction(place);
            double cosine = (double)kd_vec3_dot(d, up), sine = sin(FIXTURE_PI * (double)place.y);
            if (cosine > 0)
                sum += cosine * sine * (double)kd_sky_sample(map, d).x;
        }
    return sum * (FIXTURE_PI * step) * (2 * FIXTURE_PI / (WIDTH * cells)) / FIXTURE_PI;
}

/* One texel of 1000 at a height of 48 degrees, the rest nearly black: found by choice, not by luck. Turned by
 * 60 degrees about z, the plane's normal (0, 1, 0) is (sin 60, cos 60, 0) in the picture's space. */
static void small_bright_parts_are_found(void **state)
{
    fixture *f = *state;
    static float rgb[WIDTH * HEIGHT * 3];
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        rgb[i] = 0.001f;
    for (int c = 0; c < 3; c++)
        rgb[(7 * WIDTH + 50) * 3 + c] = 1000;
    const kd_sky_map map = {WIDTH, HEIGHT, rgb};
    look_at_plane(f, 0.5f);
    kd_entity sky = add_sky(f, rgb, (kd_quat){0, 0, 0, 1});
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 0.5 * 2 * plane_sum(&map, (kd_vec3){0, 1, 0}), 0.01);
    kd_find_mut(f->world, sky, kd_transform)->rotation = (kd_quat){0, 0, 0.5f, sqrtf(0.75f)};
    kd_vec3 up = {sqrtf(0.75f), 0.5f, 0};
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 0.5 * 2 * plane_sum(&map, up), 0.01);
}

/* Along -Z and 30 degrees up the gradient is half way from the horizon to the zenith. */
static void background_is_the_sky(void **state)
{
    fixture *f = *state;
    kd_sky sky = {.zenith = {1, 0, 0}, .horizon = {0, 1, 0}, .ground = {0, 0, 1}, .intensity = 4};
    kd_spawn(f->world, (kd_value){&kd_sky_desc, &sky}, KD_VAL(kd_transform, KD_TRANSFORM_IDENTITY),
             KD_TAG(kd_world_transform));
    f->frame->settings.light_ambient = 0.5f;
    f->desc.spp = 1;
    fixture_camera(f, (kd_vec3){0, 0, 0}, (kd_vec3){0, 0.5f, -sqrtf(0.75f)});
    const float *rgb = fixture_trace(f, KD_REFERENCE_DIRECT);
    assert_float_equal(rgb[0], 2.5f, 0.02f);
    assert_float_equal(rgb[1], 2.5f, 0.02f);
    assert_float_equal(rgb[2], 0.5f, 0.02f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(uniform_picture_is_a_uniform_sky),
        FIXTURE_TEST(small_bright_parts_are_found),
        FIXTURE_TEST(background_is_the_sky),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
