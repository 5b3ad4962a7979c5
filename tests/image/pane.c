/* What lets light through is lit by cones as well: a pane gathers what arrives at it as a wall would. */
#include "tests/image_fixture.h"

static image render(const char *scene, const char *gi, const char *ambient)
{
    char light[64];
    snprintf(light, sizeof light, "light.ambient=%s", ambient);
    image_render(scene, "--frames", "1", "--gi", gi, "--set", light, "--set", "light.bounces=1", "--set",
                 "voxels.resolution=128", "--set", "voxels.span=0.02", "--out", image_path("pane.exr"));
    return image_read("pane.exr");
}

static double middle_of(const char *scene, const char *gi, const char *ambient)
{
    image p = render(scene, gi, ambient);
    double mean = image_mean(p, 0, 28, 20, 36, 28);
    image_free(&p);
    return mean;
}

/* White, half transparent, in a sky of radiance 1: half of what it reflects and half of what is behind. */
static void a_white_pane_vanishes_in_a_white_sky(void **state)
{
    (void)state;
    const char *scene = image_scenario(
        "sky.lua", "kandil.scene { size = {64, 48} }\n"
                   "kandil.spawn { mesh = { shape = 'box', size = {2, 2, 0.02} },\n"
                   "               material = { base_color = {1, 1, 1, 0.5} } }\n"
                   "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0, 3} } }\n");
    image p = render(scene, "cones", "1");
    for (uint32_t y = 2; y < p.height - 2; y++)
        for (uint32_t x = 2; x < p.width - 2; x++)
            assert_double_near(image_mean(p, 0, x, y, x + 1, y + 1), 1, 0.04);
    image_free(&p);
}

/* A pane in the dark beside a lamp of matter, seen from the side that is lit: the light on a pane of half the
 * opacity is half of that on a wall. */
static void a_pane_gets_what_a_wall_gets(void **state)
{
    static const char lit[] =
        "kandil.scene { size = {64, 48} }\n"
        "kandil.spawn { mesh = { shape = 'box', size = {2, 2, 0.1} }, material = { base_color = {1, 1, 1, "
        "%g} "
        "} }\n"
        "kandil.spawn { mesh = { shape = 'box', size = 0.3 }, transform = { position = {0.9, 0, 0.6} },\n"
        "               material = { base_color = {0, 0, 0}, emissive = {20, 20, 20} } }\n"
        "kandil.spawn { camera = { fov_y_deg = 20 }, transform = { position = {0, 0, 3} } }\n";
    (void)state;
    double wall = middle_of(image_scenario("wall.lua", lit, 1.0), "cones", "0");
    double pane = middle_of(image_scenario("pane.lua", lit, 0.5), "cones", "0");
    double dark = middle_of(image_scenario("dark.lua", lit, 0.5), "none", "0");
    assert_true(wall > 0.05);
    assert_double_near(pane, wall / 2, 0.2 * wall / 2);
    assert_double_near(dark, 0, 1e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_pane_vanishes_in_a_white_sky),
        cmocka_unit_test(a_pane_gets_what_a_wall_gets),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
