/* A red wall and a green wall on a white floor, seen from straight above: indirect light carries their
 * colours to the floor beside them, and carries less the farther it gets. */

#include "tests/image_fixture.h"

/* 2 m between the walls; a pixel is 1/32 m, the walls' inner faces lie at pixels 16 and 80 of 96. */
static const char scene[] =
    "kandil.scene { size = {96, 64} }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {3, 0.2, 2} }, transform = { position = {0, -0.1, 0} },\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "local function wall(x, color)\n"
    "    kandil.spawn { mesh = { shape = 'box', size = {0.2, 1, 2} }, transform = { position = {x, 0.5, 0} "
    "},\n"
    "                   material = { base_color = color } }\n"
    "end\n"
    "wall(-1.1, {0.8, 0.05, 0.05})\n"
    "wall(1.1, {0.05, 0.8, 0.05})\n"
    "kandil.spawn { light = { type = 'point', intensity = 5 }, transform = { position = {0, 1.2, 0} } }\n"
    "kandil.spawn { camera = { orthographic = true, y_mag = 1 },\n"
    "               transform = { position = {0, 3, 0}, rotation_deg = {-90, 0, 0} } }\n";

/* Bands of floor, 8 pixels or a quarter of a metre wide: beside the red wall, farther out, in the middle;
 * mirrored for green. */
#define BESIDE 17
#define APART  31
#define MIDDLE 44

/* Over the middle rows of a band: how much stronger channel a is than channel b. */
static double tint(image p, int a, int b, uint32_t x)
{
    return image_mean(p, a, x, 24, x + 8, 40) / image_mean(p, b, x, 24, x + 8, 40);
}

static image render(const char *gi, const char *output)
{
    image_render(image_scenario("walls.lua", scene), "--frames", "1", "--gi", gi, "--out",
                 image_path(output));
    return image_read(output);
}

/* The floor is grey and the lamp white, so all tint is bounced. Straight from the wall's foot half of the sky
 * is wall: its bounce is a good tenth of the light there. */
static void floor_beside_a_wall_takes_its_colour(void **state)
{
    (void)state;
    image none = render("none", "none.exr"), cones = render("cones", "cones.exr");
    assert_double_near(tint(none, 0, 1, BESIDE), 1.0, 0.001);
    assert_double_near(tint(none, 1, 0, 88 - BESIDE), 1.0, 0.001);
    assert_double_above(tint(cones, 0, 1, BESIDE), 1.08);
    assert_double_above(tint(cones, 1, 0, 88 - BESIDE), 1.08);
    image_free(&none);
    image_free(&cones);
}

static void bleeding_falls_with_distance(void **state)
{
    (void)state;
    image cones = render("cones", "cones.exr");
    double red[3] = {tint(cones, 0, 1, BESIDE), tint(cones, 0, 1, APART), tint(cones, 0, 1, MIDDLE)};
    double green[3] = {tint(cones, 1, 0, 88 - BESIDE), tint(cones, 1, 0, 88 - APART),
                       tint(cones, 1, 0, 88 - MIDDLE)};
    for (int i = 0; i < 2; i++) {
        assert_double_above(red[i], red[i + 1] + 0.01);
        assert_double_above(green[i], green[i + 1] + 0.01);
    }
    image_free(&cones);
}

/* The scene is its own mirror image but for the colours: what red gets on one side, green gets on the other.
 * The voxels' lattice is no mirror image of itself, which costs some percent. */
static void both_walls_bleed_alike(void **state)
{
    (void)state;
    image cones = render("cones", "cones.exr");
    for (uint32_t x = BESIDE; x <= 71; x += 9)
        assert_double_near(tint(cones, 0, 1, x), tint(cones, 1, 0, 88 - x), 0.03);
    image_free(&cones);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floor_beside_a_wall_takes_its_colour),
        cmocka_unit_test(bleeding_falls_with_distance),
        cmocka_unit_test(both_walls_bleed_alike),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
