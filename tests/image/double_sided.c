/* What is double-sided does not light itself: of a sheet or a cube alone in the sun nothing can bounce. */
#include "tests/image_fixture.h"

/* A sheet of 4 m or a cube, white, on both sides of their faces; a sun; nothing else. */
static const char scene[] =
    "kandil.scene { size = {64, 36} }\n"
    "kandil.set('light.ambient', 0)\n"
    "kandil.spawn { mesh = { shape = '%s', size = %s }, transform = { rotation_deg = {0, 20, 0} },\n"
    "               material = { base_color = {0.8, 0.8, 0.8}, double_sided = true } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 },\n"
    "               transform = { position = {1, 3, 2}, look_at = {0, 0, 0} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 50 }, transform = { position = {0.8, 1.6, 2.6}, look_at = {0, "
    "0.2, "
    "0} } }\n";

static double light_of(const char *shape, const char *size, const char *view)
{
    image_render(image_scenario("alone.lua", scene, shape, size), "--frames", "8", "--gi", "cones", "--view",
                 view, "--out", image_path("alone.exr"));
    image p = image_read("alone.exr");
    double mean = image_mean(p, 1, 0, 0, p.width, p.height);
    image_free(&p);
    return mean;
}

/* Half of direct light came back to the sheet and four tenths to the cube when both sides sent out the mean
 * of what lit them. */
static void check(const char *shape, const char *size)
{
    double direct = light_of(shape, size, "direct"), indirect = light_of(shape, size, "indirect");
    assert_true(direct > 0.01);
    assert_double_below(indirect, 0.05 * direct);
}

static void a_sheet_does_not_light_itself(void **state)
{
    (void)state;
    check("plane", "4");
}

static void a_cube_does_not_light_itself(void **state)
{
    (void)state;
    check("box", "0.8");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sheet_does_not_light_itself),
        cmocka_unit_test(a_cube_does_not_light_itself),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
