/* A lamp inside of a box on a floor lights nothing that is seen: not where the box meets the floor, whose
 * cells hold surfaces of opposite sides, and not when the box with its lamp moves. */
#include "tests/image_fixture.h"

/* A dark yard, a box of 0.8 m, a lamp of 5 cd in it or above it; `moves`: both go a little every step. */
static const char yard[] =
    "kandil.scene { size = {64, 48}, fps = 24 }\n"
    "kandil.set('voxels.span', %g)\n"
    "kandil.spawn { mesh = { shape = 'box', size = {4, 0.2, 4} }, transform = { position = {0, -0.1, 0} },\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "local top = kandil.spawn { transform = { position = {0, 0, 0} } }\n"
    "kandil.spawn { parent = top, mesh = { shape = 'box', size = 0.8 }, transform = { position = {0, 0.4, 0} "
    "},\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "kandil.spawn { parent = top, light = { type = 'point', intensity = 5 }, transform = { position = {0, "
    "%g, 0} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 50 }, transform = { position = {0.6, 1.6, 2.4}, look_at = {0, "
    "0.2, 0} } }\n"
    "if %s then function kandil.update(t) top.transform.position = {0.1 * math.sin(9 * t), 0, 0} end end\n";

static double light_of(double span, double height, const char *moves)
{
    const char *scene = image_scenario("yard.lua", yard, span, height, moves);
    image_render(scene, "--frames", "4", "--gi", "cones", "--out", image_path("yard.exr"));
    image p = image_read("yard.exr");
    double mean = image_mean(p, 1, 0, 0, p.width, p.height);
    image_free(&p);
    return mean;
}

/* Without asking what shuts a lamp in, cells under the box gave 0.04 of the open lamp's light, and 0.22 while
 * it moved. */
static void a_lamp_in_a_box_lights_nothing_else(void **state)
{
    (void)state;
    double open = light_of(0.03, 1.2, "false");
    assert_true(open > 0.1);
    assert_true(light_of(0.03, 0.4, "false") < 0.002 * open);
    assert_true(light_of(0.03, 0.4, "true") < 0.002 * open);
}

/* Half of what such a lamp sees is the box's bottom, whose cells hold the floor too. */
static void a_low_lamp_is_shut_in_as_well(void **state)
{
    (void)state;
    assert_true(light_of(0.02, 0.2, "false") < 0.0004);
    assert_true(light_of(0.02, 0.1, "false") < 0.0004);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_in_a_box_lights_nothing_else),
        cmocka_unit_test(a_low_lamp_is_shut_in_as_well),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
