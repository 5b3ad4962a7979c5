/* What flickers while a camera moves slowly, as `kandil compare --temporal` measures it. */

#include "tests/image_fixture.h"

/* A room with a pillar, lit by a lamp; bounces of lamps alone, so that no frame has to settle. */
static const char room[] =
    "kandil.scene { size = {160, 90}, fps = 30, settings = { ['light.bounces'] = '1', ['voxels.span'] = 0.05 "
    "} }\n"
    "local function box(x, y, z, a, b, c, color)\n"
    "    kandil.spawn { mesh = { shape = 'box', size = {a, b, c} }, transform = { position = {x, y, z} },\n"
    "                   material = { base_color = color } }\n"
    "end\n"
    "box(0, -0.1, 0, 4, 0.2, 4, {0.7, 0.7, 0.7})\n"
    "box(0, 2.1, 0, 4, 0.2, 4, {0.7, 0.7, 0.7})\n"
    "box(-2.1, 1, 0, 0.2, 2.4, 4, {0.7, 0.2, 0.1})\n"
    "box(2.1, 1, 0, 0.2, 2.4, 4, {0.2, 0.6, 0.1})\n"
    "box(0, 1, -2.1, 4.4, 2.4, 0.2, {0.7, 0.7, 0.7})\n"
    "box(0.4, 0.6, -0.6, 0.5, 1.2, 0.5, {0.6, 0.6, 0.7})\n"
    "local lamp = kandil.spawn { light = { type = 'point', intensity = 6 },\n"
    "                            transform = { position = {-0.5, 1.6, 0} } }\n"
    "local eye = kandil.spawn { camera = %s, transform = { position = {0, 1, 3} } }\n"
    "function kandil.update(t)\n"
    "    eye.transform.position = {%s * t, 1, 3}\n"
    "    lamp.light.intensity = %s\n"
    "end\n";

/* Of the terms final, direct and indirect. */
static void measure(const char *before, const char *now, double flip[3])
{
    void *text;
    size_t size;
    assert_int_equal(image_kandil("compare", image_path(before), image_path(now), "--temporal", "--json",
                                  image_path("t.json"), "--html", image_path("t.html")),
                     0);
    assert_int_equal(kd_file_read(image_path("t.json"), KD_FILE_NO_LIMIT, &text, &size), KD_OK);
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        at = strstr(at, "\"flip_ldr\": ");
        assert_non_null(at);
        at += strlen("\"flip_ldr\": ");
        flip[i] = strtod(at, NULL);
    }
    free(text);
}

static void render(const char *camera, const char *speed, const char *lamp, const char *gi)
{
    image_scenario("room.lua", room, camera, speed, lamp);
    image_render(image_path("room.lua"), "--frames", "3", "--gi", gi, "--layers", "--out",
                 image_path("f%d.exr"));
}

static void a_slow_camera_sees_steady_light(void **state)
{
    double flip[3];
    (void)state;
    render("{ fov_y_deg = 40 }", "0.3", "6", "cones");
    measure("f1.exr", "f2.exr", flip);
    assert_double_above(flip[0], 0); /* edges between texels differ */
    assert_double_below(flip[0], 0.015);
}

/* Seen without perspective at 45 pixels a metre, a camera that goes 1/45 m a step to the right takes all to
 * the left by a pixel. */
static void whole_pixels_do_not_flicker(void **state)
{
    double flip[3];
    (void)state;
    render("{ orthographic = true, y_mag = 1 }", "30 / 45", "6", "none");
    measure("f1.exr", "f2.exr", flip);
    assert_double_below(flip[0], 1e-3); /* shadows are as exact as floats are */
}

static void a_lamp_that_flickers_is_seen(void **state)
{
    double flip[3];
    (void)state;
    render("{ fov_y_deg = 40 }", "0", "t > 0.05 and 9 or 6", "cones");
    measure("f0.exr", "f1.exr", flip);
    assert_double_below(flip[0], 1e-9);
    measure("f1.exr", "f2.exr", flip);
    for (int i = 0; i < 3; i++)
        assert_double_above(flip[i], 0.05);
}

static void refuses_what_has_no_layers(void **state)
{
    (void)state;
    image_scenario("room.lua", room, "{}", "0", "6");
    image_render(image_path("room.lua"), "--frames", "2", "--gi", "none", "--out", image_path("plain%d.exr"));
    assert_int_equal(
        image_kandil("compare", image_path("plain0.exr"), image_path("plain1.exr"), "--temporal"), 1);
    assert_non_null(strstr(image_message, "--layers"));
    assert_int_equal(image_kandil("compare", image_path("room.lua"), "--temporal"), 2);
    assert_int_equal(kd_file_write(image_path("broken.exr"), "no picture", 10), KD_OK);
    assert_int_equal(
        image_kandil("compare", image_path("broken.exr"), image_path("plain1.exr"), "--temporal"), 1);
    assert_non_null(strstr(image_message, "broken.exr"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slow_camera_sees_steady_light),
        cmocka_unit_test(whole_pixels_do_not_flicker),
        cmocka_unit_test(a_lamp_that_flickers_is_seen),
        cmocka_unit_test(refuses_what_has_no_layers),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
