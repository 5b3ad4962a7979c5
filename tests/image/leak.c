/* Light stays where walls keep it: a lamp in a closed box, seen from outside. */

#include "tests/image_fixture.h"

#define PI 3.14159265358979

/* A box of white slabs, 1 m inside, on a floor. The lamp's 10 candela make the middle of each inner wall 0.8
 * / pi 10 / 0.5^2 bright; all that the camera sees lies in the dark. */
static const char scene[] =
    "kandil.scene { size = {96, 54} }\n"
    "local t = %g\n"
    "for axis = 1, 3 do\n"
    "    for side = -1, 1, 2 do\n"
    "        local size, place = {1 + 2 * t, 1 + 2 * t, 1 + 2 * t}, {0, 0.5, 0}\n"
    "        size[axis], place[axis] = t, place[axis] + (1 + t) / 2 * side\n"
    "        kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = place },\n"
    "                       material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "    end\n"
    "end\n"
    "kandil.spawn { mesh = { shape = 'box', size = {6, 0.2, 6} }, transform = { position = {0, -0.1 - t, 0} "
    "},\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "kandil.spawn { light = { type = 'point', intensity = 10 }, transform = { position = {0, 0.5, 0} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 50 }, transform = { position = {1.6, 1.6, 2.4}, look_at = {0, "
    "0.3, 0} } }\n";

static image render(double wall_m, const char *view)
{
    image_render(image_scenario("closed.lua", scene, wall_m), "--frames", "1", "--set", "light.bounces=1",
                 "--view", view, "--out", image_path("closed.exr"));
    return image_read("closed.exr");
}

static double brightest(image p)
{
    double top = 0;
    for (size_t i = 0; i < image_count(p); i++)
        top = fmax(top, (double)p.rgb[i]);
    return top;
}

/* Relative to the inner walls. */
static double leaked(double wall_m)
{
    image p = render(wall_m, "indirect");
    double mean = image_mean_all(p) / (0.8 / PI * 10 / (0.5 * 0.5));
    image_free(&p);
    return mean;
}

static void direct_light_stays_inside(void **state)
{
    (void)state;
    image p = render(0.02, "direct");
    assert_double_near(brightest(p), 0, 0);
    image_free(&p);
}

/* A wall of 2.5 voxels has no voxel with both an inner and an outer side. */
static void outer_voxels_are_dark(void **state)
{
    (void)state;
    image p = render(0.05, "octree");
    assert_double_near(brightest(p), 0, 0);
    image_free(&p);
}

/* Cones read large cells far away, and a cell larger than the wall is thick shows something of both sides. */
static void little_indirect_light_gets_out(void **state)
{
    (void)state;
    double thin = leaked(0.1), thick = leaked(0.4);
    if (getenv("KD_KEEP_PICTURES"))
        print_message("leaked: %.4f through 5 voxels, %.4f through 20\n", thin, thick);
    assert_double_below(thin, 0.02);
    assert_double_below(thick, 0.005);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(direct_light_stays_inside),
        cmocka_unit_test(outer_voxels_are_dark),
        cmocka_unit_test(little_indirect_light_gets_out),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
