/* `view.steady`: pictures mixed with those before while the camera moves are nearer to what many samples a
 * pixel show; what stands still, and what moves by itself, is as it was. */

#include "tests/image_fixture.h"

/* A grid of thin bars in front of a wall; the camera goes aside for ten frames, then stands. */
static const char grid[] =
    "kandil.scene { size = {96, 54}, fps = 30 }\n"
    "for i = -12, 12 do\n"
    "    kandil.spawn { mesh = { shape = 'box', size = {0.03, 4, 0.03} }, transform = { position = {i * "
    "0.17, 0, 0},\n"
    "                   rotation_deg = {0, 0, %s} }, material = { base_color = {0.9, 0.9, 0.9} }, name = "
    "'bar' .. i }\n"
    "end\n"
    "%s\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3, no_shadow = true } }\n"
    "local eye = kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0, 3} } }\n"
    "function kandil.update(t)\n"
    "    eye.transform.position = {0.013 * math.min(10, t * 30), 0.007 * math.min(10, t * 30), 3}\n"
    "    if %s then\n"
    "        for i = -12, 12 do\n"
    "            kandil.find('bar' .. i).transform.position = {i * 0.17 - 0.02 * t * 30, 0, 0}\n"
    "        end\n"
    "    end\n"
    "end\n";

static void render(const char *turn_deg, const char *wall, const char *moves)
{
    image_scenario("grid.lua", grid, turn_deg, wall, moves);
    image_render(image_path("grid.lua"), "--frames", "30", "--gi", "none", "--set", "view.steady=on", "--out",
                 image_path("on%d.exr"));
    image_render(image_path("grid.lua"), "--frames", "30", "--gi", "none", "--set", "view.steady=off",
                 "--out", image_path("off%d.exr"));
}

/* Mean distance of two pictures. */
static double distance(const char *one, const char *other)
{
    image a = image_read(one), b = image_read(other);
    size_t values = (size_t)a.width * a.height * 3;
    double sum = 0;
    for (size_t i = 0; i < values; i++)
        sum += fabs((double)a.rgb[i] - (double)b.rgb[i]);
    image_free(&a);
    image_free(&b);
    return sum / (double)values;
}

static const char wall[] =
    "kandil.spawn { mesh = { shape = 'box', size = {9, 9, 0.1} }, transform = { position = "
    "{0, 0, -1} }, material = { base_color = {0.05, 0.1, 0.2} } }";

static void moving_pictures_are_as_of_more_samples(void **state)
{
    (void)state;
    render("7", wall, "false");
    image_render(image_path("grid.lua"), "--frames", "10", "--gi", "none", "--supersample", "6", "--out",
                 image_path("many%d.exr"));
    double mixed = distance("on9.exr", "many9.exr"), plain = distance("off9.exr", "many9.exr");
    assert_double_above(mixed, 0);
    assert_double_below(mixed, 0.9 * plain);
}

/* The frame before the first one that moves has not been kept. After sixteen frames nothing is left of
 * others. */
static void standing_pictures_are_left_alone(void **state)
{
    (void)state;
    render("7", wall, "false");
    assert_true(distance("on0.exr", "off0.exr") == 0);
    assert_true(distance("on9.exr", "off9.exr") > 0);
    assert_true(distance("on28.exr", "off28.exr") == 0);
    assert_true(distance("on29.exr", "on28.exr") == 0);
}

static void what_moves_by_itself_leaves_no_trail(void **state)
{
    (void)state;
    render("0", "", "true");
    assert_true(distance("on9.exr", "off9.exr") == 0);
    assert_true(distance("on9.exr", "on8.exr") > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moving_pictures_are_as_of_more_samples),
        cmocka_unit_test(standing_pictures_are_left_alone),
        cmocka_unit_test(what_moves_by_itself_leaves_no_trail),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
