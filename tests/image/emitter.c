/* Light of a lamp that is a surface: a square panel in a ceiling, and the wall behind it. What reaches the
 * wall is known by quadrature over the panel. */
#include "tests/image_fixture.h"

#define PI     3.14159265358979
#define ALBEDO 0.5

/* A wall of 2 x 2 m at z = -1 that fills the picture, a ceiling at y = 1 and in it a panel of radiance 10. */
static const char scene[] =
    "kandil.scene { size = {32, 32} }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {2, 2, 0.1} }, transform = { position = {0, 0, -1.05} },\n"
    "               material = { base_color = {0.5, 0.5, 0.5} } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {2, 0.1, 2} }, transform = { position = {0, 1.05, 0} },\n"
    "               material = { base_color = {0, 0, 0} } }\n"
    "kandil.spawn { mesh = { shape = 'plane', size = {0.6, 1, 0.6} },\n"
    "               transform = { position = {0, 0.999, 0}, rotation_deg = {180, 0, 0} },\n"
    "               material = { base_color = {0, 0, 0}, emissive = {10, 10, 10} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 53.13010235 }, transform = { position = {0, 0, 1} } }\n";

/* Radiance of the wall in the middle, `up` below a side of the panel: albedo / pi times the irradiance from
 * it. */
static double exact(double up)
{
    enum { CELLS = 40 };
    double sum = 0, edge = 0.6 / CELLS;
    for (int i = 0; i < CELLS * CELLS; i++) {
        double x = -0.3 + (i % CELLS + 0.5) * edge, z = -0.3 + (i / CELLS + 0.5) * edge, out = z + 1;
        double d2 = x * x + up * up + out * out;
        sum += out * up / (d2 * d2);
    }
    return ALBEDO / PI * 10 * sum * edge * edge;
}

/* Rows go from y = 1 down to -1. Near the ceiling the panel is seen at a grazing angle, by the edges of wide
 * cones. */
static void a_panel_lights_the_wall_beside_it_from_top_to_bottom(void **state)
{
    (void)state;
    image_render(image_scenario("panel.lua", scene), "--frames", "1", "--view", "indirect", "--out",
                 image_path("panel.exr"));
    image p = image_read("panel.exr");
    for (uint32_t row = 2; row < 30; row += 4) {
        double got = image_mean(p, 0, 12, row, 20, row + 4), wanted = exact((row + 2) / 16.0);
        if (getenv("KD_KEEP_PICTURES"))
            print_message("rows %u to %u: %.3f of what is exact\n", row, row + 3, got / wanted);
        assert_double_above(got, 0.4 * wanted);
        assert_double_below(got, 1.7 * wanted);
    }
    image_free(&p);
}

/* The same wall and a panel 2 cm thick that hangs free: both sides of it lie in one voxel of 5 cm, and each
 * lights its half of the wall. */
static const char hanging[] =
    "kandil.scene { size = {32, 32} }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {2, 2, 0.1} }, transform = { position = {0, 0, -1.05} },\n"
    "               material = { base_color = {0.5, 0.5, 0.5} } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {0.6, 0.02, 0.6} }, transform = { position = {0, 0, 0} "
    "},\n"
    "               material = { base_color = {0, 0, 0}, emissive = {10, 10, 10} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 53.13010235, z_near = 1.4 }, transform = { position = {0, 0, 1} } "
    "}\n";

static void a_thin_panel_shines_from_both_sides(void **state)
{
    (void)state;
    image_render(image_scenario("hanging.lua", hanging), "--frames", "1", "--view", "indirect", "--out",
                 image_path("hanging.exr"));
    image p = image_read("hanging.exr");
    for (uint32_t row = 0; row < 32; row += 4) {
        double up = fabs(1 - (row + 2) / 16.0) - 0.01,
               edge = 0.7 * 0.7 / pow(0.7 * 0.7 + up * up, 2) * 0.6 * 0.02;
        double got = image_mean(p, 0, 12, row, 20, row + 4), wanted = exact(up) + ALBEDO / PI * 10 * edge;
        if (getenv("KD_KEEP_PICTURES"))
            print_message("rows %u to %u: %.3f of what is exact\n", row, row + 3, got / wanted);
        assert_double_above(got, 0.7 * wanted);
        assert_double_below(got, 1.3 * wanted);
    }
    image_free(&p);
}

/* A plane without width has no area. What is beside it must be lit as if it were not there. */
static void what_is_flattened_to_a_line_does_not_shine(void **state)
{
    static const char line[] =
        "%skandil.spawn { mesh = { shape = 'plane', size = {1, 1, 1} }, material = { emissive = {100, 100, "
        "100} },\n"
        "               transform = { position = {0, 0, -0.5}, scale = {0, 1, 1} } }\n";
    (void)state;
    image_render(image_scenario("panel.lua", scene), "--frames", "2", "--view", "indirect", "--out",
                 image_path("without.exr"));
    image_render(image_scenario("line.lua", line, scene), "--frames", "2", "--view", "indirect", "--out",
                 image_path("with.exr"));
    image a = image_read("without.exr"), b = image_read("with.exr");
    assert_double_near(image_mean_all(b), image_mean_all(a),
                       0.02 * image_mean_all(a)); /* brighter units are coarser */
    image_free(&a);
    image_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_panel_lights_the_wall_beside_it_from_top_to_bottom),
        cmocka_unit_test(what_is_flattened_to_a_line_does_not_shine),
        cmocka_unit_test(a_thin_panel_shines_from_both_sides),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
