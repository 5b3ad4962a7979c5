/* Light is stored in a unit that doubles as the scene brightens. What bounces does not show when it does. */
#include "tests/image_fixture.h"

#include <math.h>

enum { FRAMES = 24 };

/* A hall with a roof that is open on one side, under a sun of so many lux that shines a little brighter in
 * every step. */
static void render(double lux, const char *pattern)
{
    image_render(
        image_scenario(
            "hall.lua",
            "kandil.scene { size = {64, 48}, fps = 10 }\n"
            "local function box(p, s)\n"
            "    kandil.spawn { mesh = { shape = 'box', size = s }, material = { base_color = {0.8, 0.8, "
            "0.8} },\n"
            "                   transform = { position = p } }\n"
            "end\n"
            "box({0, -0.1, 0}, {4, 0.2, 4}) box({-2, 1, 0}, {0.2, 2, 4}) box({2, 1, 0}, {0.2, 2, 4})\n"
            "box({0, 1, -2}, {4, 2, 0.2}) box({-0.8, 2.1, 0}, {2.6, 0.2, 4})\n"
            "local sun = kandil.spawn { light = { type = 'directional', intensity = %g },\n"
            "                           transform = { look_at = {0.1, -1, -0.1} } }\n"
            "kandil.set('view.exposure_ev', -11)\n"
            "kandil.spawn { camera = { fov_y_deg = 60 }, transform = { position = {0, 1, 1.9},\n"
            "                                                          look_at = {-0.5, 1, -1} } }\n"
            "local n = 0\n"
            "function kandil.update() n = n + 1 sun.light.intensity = %g * (1 + 0.0001 * n) end\n",
            lux, lux),
        "--frames", "24", "--view", "indirect", "--out", image_path(pattern));
}

static double mean_of(const char *pattern, int frame)
{
    char name[32];
    snprintf(name, sizeof name, pattern, frame);
    image p = image_read(name);
    double mean = image_mean_all(p);
    image_free(&p);
    return mean;
}

/* 1024 pi 2 lux is where it doubles: one sun passes there, the other stays below. */
static void light_that_bounces_outlives_the_unit(void **state)
{
    (void)state;
    const double near_lux = 6428, far_lux = 5000;
    render(near_lux, "near%02d.exr");
    render(far_lux, "far%02d.exr");
    for (int i = 6; i < FRAMES; i++) {
        double ratio = mean_of("near%02d.exr", i) / mean_of("far%02d.exr", i) / (near_lux / far_lux);
        if (getenv("KD_KEEP_PICTURES"))
            print_message("%d: %.3f\n", i, ratio);
        assert_double_near(ratio, 1, 0.12);
    }
}

/* Half a million candela light a wall to more than half floats hold. Shown 17 steps darker it is the wall in
 * the light of a lamp of four: factors of powers of two change no digit. */
static void a_picture_of_very_bright_light_is_not_cut_off(void **state)
{
    static const char wall[] = "kandil.scene { size = {32, 32}, gi = 'none', exposure_ev = %d }\n"
                               "kandil.spawn { mesh = { shape = 'box', size = {2, 2, 0.1} }, transform = { "
                               "position = {0, 0, -1} } }\n"
                               "kandil.spawn { light = { type = 'point', intensity = 4 * 2 ^ %d }, transform "
                               "= { position = {0.3, 0, 0} } }\n"
                               "kandil.spawn { camera = {}, transform = { position = {0, 0, 1} } }\n";
    (void)state;
    image_render(image_scenario("four.lua", wall, -1, 0), "--frames", "1", "--out", image_path("four.png"));
    image_render(image_scenario("bright.lua", wall, -18, 17), "--frames", "1", "--out",
                 image_path("bright.png"));
    image four = image_read("four.png");
    assert_false(image_is_constant(four));
    image_free(&four);
    assert_same_file("four.png", "bright.png");
}

/* A white corner in the light of half a million candela, and of four: light that is gathered is kept in the
 * unit of the tree, of which four candela near by have another multiple. The darker view of the bright one is
 * the other one within the steps of the numbers. */
static void gathered_light_is_not_cut_off(void **state)
{
    static const char corner[] =
        "kandil.scene { size = {48, 48}, gi = 'cones', exposure_ev = %d }\n"
        "local white = { base_color = {0.8, 0.8, 0.8} }\n"
        "kandil.spawn { mesh = { shape = 'box', size = {2, 0.2, 2} }, transform = { position = {0, -0.1, 0} "
        "}, "
        "material = white }\n"
        "kandil.spawn { mesh = { shape = 'box', size = {2, 2, 0.2} }, transform = { position = {0, 1, -1} }, "
        "material = white }\n"
        "kandil.spawn { light = { type = 'point', intensity = 4 * 2 ^ %d }, transform = { position = {0, "
        "0.6, "
        "-0.4} } }\n"
        "kandil.spawn { camera = {}, transform = { position = {0, 0.8, 2}, look_at = {0, 0.5, 0} } }\n";
    (void)state;
    image_render(image_scenario("four.lua", corner, -2, 0), "--frames", "4", "--view", "indirect", "--out",
                 image_path("four.png"));
    image_render(image_scenario("bright.lua", corner, -19, 17), "--frames", "4", "--view", "indirect",
                 "--out", image_path("bright.png"));
    image four = image_read("four.png"), bright = image_read("bright.png");
    image_error error = image_difference(four, bright);
    assert_double_above(image_mean_all(four), 0.1);
    assert_double_below(error.mean, 0.002);
    image_free(&four);
    image_free(&bright);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_that_bounces_outlives_the_unit),
        cmocka_unit_test(gathered_light_is_not_cut_off),
        cmocka_unit_test(a_picture_of_very_bright_light_is_not_cut_off),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
