/* What is kept between frames never changes a picture, only its cost: the layer of what stands still, moved
 * along with the camera, gives what a tree made from nothing gives. */

#include "tests/image_fixture.h"

/* A row of boxes along a wall, 8 m long: far more than the finest cascade holds at a time. In frame 3 the
 * camera is at the row's other end, or it has been there all the time. */
static const char flight[] =
    "kandil.scene { size = {96, 54}, fps = 10 }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {9, 0.2, 3} }, transform = { position = {0, -0.1, 0} },\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {9, 1.5, 0.2} }, transform = { position = {0, 0.75, -1.1} "
    "},\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "for i = -8, 8 do\n"
    "    kandil.spawn { mesh = { shape = i %% 2 == 0 and 'box' or 'sphere', size = 0.3 }, transform = { "
    "position = {i / 2, 0.15, -0.5} },\n"
    "                   material = { base_color = {0.5 + 0.4 * math.sin(i), 0.5 + 0.4 * math.cos(i), 0.3} } "
    "}\n"
    "end\n"
    "kandil.spawn { light = { type = 'directional', intensity = 4 }, transform = { look_at = {-0.6, -1, "
    "-0.7} } }\n"
    "local camera = kandil.spawn { camera = { fov_y_deg = 45 }, transform = { position = {%g, 1, 1.6}, "
    "look_at = {%g, 0.2, -0.6} } }\n"
    "function kandil.update(t)\n"
    "    if t < 0.25 then return end\n"
    "    camera.transform.position = {3, 1, 1.6}\n"
    "    camera.transform.look_at = {3, 0.2, -0.6}\n"
    "end\n";

/* A box and a lamp, both there for two frames or from the start; see each test. */
static const char things[] =
    "kandil.scene { size = {96, 54}, fps = 10 }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {3, 0.2, 2} }, transform = { position = {0, -0.1, 0} },\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "local function red() return kandil.spawn { mesh = { shape = 'box', size = 0.5 }, transform = { position "
    "= {0, 0.25, 0} },\n"
    "                                           material = { base_color = {0.9, 0.1, 0.1} } } end\n"
    "local function lamp() return kandil.spawn { light = { type = 'spot', intensity = 12, outer_cone_deg = "
    "70 },\n"
    "                                            transform = { position = {0.4, 2, 1}, look_at = {0, 0, 0} } "
    "} end\n"
    "kandil.spawn { light = { type = 'directional', intensity = 1 }, transform = { look_at = {0.6, -1, -0.4} "
    "} }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1.4, 3}, look_at = {0, 0.3, 0} "
    "} }\n"
    "%s\n";

static image render(const char *scene, const char *frames, const char *layers, const char *output)
{
    image_render(scene, "--frames", frames, "--set", "light.bounces=1", "--set", layers, "--out",
                 image_path(output));
    return image_read(output);
}

/* The pictures are equal to the last bit, and `other` is not, so that equality says something. */
static void assert_equal_but_not(image a, image b, image other)
{
    image_error same = image_difference(a, b), different = image_difference(a, other);
    if (same.max > 0)
        fail_msg("differ by %g at most, %g on average", same.max, same.mean);
    assert_double_above(different.mean, 0.005);
    image_free(&a);
    image_free(&b);
    image_free(&other);
}

static void a_flight_leaves_nothing_behind(void **state)
{
    (void)state;
    image flown =
        render(image_scenario("flight.lua", flight, -3.0, -3.0), "4", "svo.layers=two", "flown.exr");
    image there = render(image_scenario("flight.lua", flight, 3.0, 3.0), "1", "svo.layers=two", "there.exr");
    image start =
        render(image_scenario("flight.lua", flight, -3.0, -3.0), "1", "svo.layers=two", "start.exr");
    assert_equal_but_not(flown, there, start);
}

static void one_layer_gives_the_picture_of_two(void **state)
{
    (void)state;
    image two = render(image_scenario("flight.lua", flight, -3.0, -3.0), "4", "svo.layers=two", "two.exr");
    image one = render(image_scenario("flight.lua", flight, -3.0, -3.0), "4", "svo.layers=one", "one.exr");
    image start =
        render(image_scenario("flight.lua", flight, -3.0, -3.0), "1", "svo.layers=one", "start.exr");
    assert_equal_but_not(two, one, start);
}

static image render_things(const char *what, const char *output)
{
    return render(image_scenario("things.lua", things, what), "5", "svo.layers=two", output);
}

static void a_box_that_comes_is_there(void **state)
{
    (void)state;
    image came = render_things("kandil.at(0.25, function() red() end) lamp()", "came.exr");
    assert_equal_but_not(came, render_things("red() lamp()", "both.exr"),
                         render_things("lamp()", "lamp.exr"));
}

static void a_box_that_goes_is_gone(void **state)
{
    (void)state;
    image gone =
        render_things("local r = red() kandil.at(0.25, function() r:destroy() end) lamp()", "gone.exr");
    assert_equal_but_not(gone, render_things("lamp()", "lamp.exr"),
                         render_things("red() lamp()", "both.exr"));
}

static void a_lamp_that_comes_shines(void **state)
{
    (void)state;
    image on = render_things("red() kandil.at(0.25, function() lamp() end)", "on.exr");
    assert_equal_but_not(on, render_things("red() lamp()", "both.exr"), render_things("red()", "box.exr"));
}

static void a_lamp_that_goes_out_is_dark(void **state)
{
    (void)state;
    image out =
        render_things("red() local l = lamp() kandil.at(0.25, function() l:destroy() end)", "out.exr");
    assert_equal_but_not(out, render_things("red()", "box.exr"), render_things("red() lamp()", "both.exr"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flight_leaves_nothing_behind),
        cmocka_unit_test(one_layer_gives_the_picture_of_two),
        cmocka_unit_test(a_box_that_comes_is_there),
        cmocka_unit_test(a_box_that_goes_is_gone),
        cmocka_unit_test(a_lamp_that_comes_shines),
        cmocka_unit_test(a_lamp_that_goes_out_is_dark),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
