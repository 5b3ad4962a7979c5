/* The whole scene turned about the vertical, with its lamps and its camera, gives the same picture. By
 * quarter turns the voxels' lattice falls onto itself; by 30 degrees it does not, and the voxels of every
 * wall differ. */

#include "tests/image_fixture.h"

/* Everything hangs on one entity that turns. A room open towards the camera: nothing in it is symmetric. */
static const char scene[] =
    "kandil.scene { size = {96, 54} }\n"
    "local all = kandil.spawn { transform = { rotation_deg = {0, %g, 0} } }\n"
    "local function box(size, position, color)\n"
    "    kandil.spawn { parent = all, mesh = { shape = 'box', size = size }, transform = { position = "
    "position },\n"
    "                   material = { base_color = color } }\n"
    "end\n"
    "box({2.4, 0.2, 2.2}, {0, -0.1, 0}, {0.7, 0.7, 0.7})\n"
    "box({2.4, 0.2, 2.2}, {0, 1.9, 0}, {0.7, 0.7, 0.7})\n"
    "box({2.4, 1.8, 0.2}, {0, 0.9, -1}, {0.7, 0.7, 0.7})\n"
    "box({0.2, 1.8, 2}, {-1.1, 0.9, 0}, {0.7, 0.06, 0.05})\n"
    "box({0.2, 1.8, 2}, {1.1, 0.9, 0}, {0.1, 0.5, 0.09})\n"
    "box({0.5, 0.9, 0.4}, {-0.4, 0.45, -0.4}, {0.7, 0.7, 0.7})\n"
    "kandil.spawn { parent = all, mesh = { shape = 'sphere', size = 0.6 }, transform = { position = {0.45, "
    "0.3, 0.1} },\n"
    "               material = { base_color = {0.7, 0.6, 0.2} } }\n"
    "kandil.spawn { parent = all, light = { type = 'spot', intensity = 8, outer_cone_deg = 80 },\n"
    "               transform = { position = {0.2, 1.75, 0.1}, rotation_deg = {-90, 0, 0} } }\n"
    "kandil.spawn { parent = all, light = { type = 'directional', intensity = 1.5 },\n"
    "               transform = { rotation_deg = {-25, 20, 0} } }\n"
    "kandil.spawn { parent = all, camera = { fov_y_deg = 40 }, transform = { position = {0, 0.95, 3.4} } }\n";

static image render(double turn_deg)
{
    char name[32];
    snprintf(name, sizeof name, "turn%g.png", turn_deg);
    /* where few pixels are traced, which ones hangs on small differences */
    image_render(image_scenario("turned.lua", scene, turn_deg), "--frames", "1", "--set", "cones.refine=0",
                 "--out", image_path(name));
    return image_read(name);
}

/* Compare with the scene as it stands; errors are of the picture as shown, from 0 to 1. */
static void assert_turned_is_the_same(double turn_deg, double mean, double p99)
{
    image still = render(0), turned = render(turn_deg);
    image_error e = image_difference(still, turned);
    if (e.mean > mean || e.p99 > p99)
        fail_msg("turned by %g: mean error %g (at most %g), p99 %g (at most %g)", turn_deg, e.mean, mean,
                 e.p99, p99);
    image_free(&still);
    image_free(&turned);
}

/* One step of 8 bits is 0.0039: on average less than one, and three steps at the hundredth pixel. Surfaces
 * that lie on the border of two voxels fall to the one on the other side. */
static void quarter_turns_change_next_to_nothing(void **state)
{
    (void)state;
    assert_turned_is_the_same(90, 0.003, 0.024);
    assert_turned_is_the_same(180, 0.003, 0.024);
    assert_turned_is_the_same(270, 0.003, 0.024);
}

/* Slanted walls cover other voxels, and cover them otherwise; cells that cones read are boxes along the axes.
 */
static void any_turn_changes_little(void **state)
{
    (void)state;
    assert_turned_is_the_same(30, 0.012, 0.07);
    assert_turned_is_the_same(200, 0.012, 0.07);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quarter_turns_change_next_to_nothing),
        cmocka_unit_test(any_turn_changes_little),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
