/* Floors far larger than the voxel grid: only what the cascades can hold is voxelized, so that size costs
 * nothing. */
#include "tests/image_fixture.h"

static const char floor_scene[] =
    "kandil.scene { size = {64, 36} }\n"
    "kandil.spawn { mesh = { shape = 'plane', size = {%d, 1, %d} }, material = { base_color = {0.8, 0.1, "
    "0.1} } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = 1 }, transform = { position = {0, 0.5, 0} } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {0, -1, -0.01} "
    "} }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1, 3.5}, look_at = {0, 0.5, 0} "
    "} }\n";

/* The box's front, which the sun does not reach: all that it shows is the floor's bounce, so it is red. */
static double bounce_on_the_box(int edge)
{
    image_render(image_scenario("floor.lua", floor_scene, edge, edge), "--frames", "1", "--view", "indirect",
                 "--out", image_path("floor.exr"));
    image p = image_read("floor.exr");
    double red = image_mean(p, 0, 29, 16, 35, 20), green = image_mean(p, 1, 29, 16, 35, 20);
    image_free(&p);
    assert_true(red > 4 * green);
    return red;
}

/* 8 m are voxelized whole in the outer cascades, 1 km in none: beyond what the grid holds it makes no
 * difference. */
static void floor_of_a_kilometre_bounces_as_one_of_eight_metres(void **state)
{
    (void)state;
    double small = bounce_on_the_box(8), large = bounce_on_the_box(1000);
    assert_true(small > 0.05);
    assert_double_near(large, small, 0.1 * small);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floor_of_a_kilometre_bounces_as_one_of_eight_metres),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
