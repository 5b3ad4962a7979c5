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

/* Radiance of the wall at height y, in the middle: albedo / pi times the panel's irradiance. */
static double exact(double y)
{
    enum { CELLS = 40 };
    double sum = 0, edge = 0.6 / CELLS;
    for (int i = 0; i < CELLS * CELLS; i++) {
        double x = -0.3 + (i % CELLS + 0.5) * edge, z = -0.3 + (i / CELLS + 0.5) * edge, up = 1 - y,
               out = z + 1;
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
        double got = image_mean(p, 0, 12, row, 20, row + 4), wanted = exact(1 - (row + 2) / 16.0);
        if (getenv("KD_KEEP_PICTURES"))
            print_message("rows %u to %u: %.3f of what is exact\n", row, row + 3, got / wanted);
        assert_double_above(got, 0.4 * wanted);
        assert_double_below(got, 1.7 * wanted);
    }
    image_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_panel_lights_the_wall_beside_it_from_top_to_bottom)};
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
