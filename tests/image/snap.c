/* Cascades move in steps as the camera does. Two frames a millimetre apart with such a step between them
 * differ hardly more than two without: nothing pops. */

#include "tests/image_fixture.h"

enum { RESOLUTION = 128, CASCADES = 3 };
static const double SPAN = 0.02, MILLIMETRE = 0.001;

/* A hall seven metres long, of which the finest cascade holds a third; the camera looks along it. */
static const char hall[] =
    "kandil.scene { size = {160, 90}, fps = 10 }\n"
    "local function box(size, position, color)\n"
    "    kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = position },\n"
    "                   material = { base_color = color } }\n"
    "end\n"
    "box({14, 0.2, 4}, {0, -0.1, 0}, {0.8, 0.8, 0.8})\n"
    "box({14, 2.2, 0.2}, {0, 1.1, -1.6}, {0.8, 0.5, 0.4})\n"
    "box({14, 0.2, 4}, {0, 2.3, 0}, {0.8, 0.8, 0.8})\n"
    "for i = -12, 12 do\n"
    "    kandil.spawn { mesh = { shape = i %% 2 == 0 and 'box' or 'sphere', size = 0.3 },\n"
    "                   transform = { position = {i / 2, 0.15, -0.6} },\n"
    "                   material = { base_color = {0.5 + 0.4 * math.sin(i), 0.5 + 0.4 * math.cos(i), 0.3} } "
    "}\n"
    "end\n"
    "kandil.spawn { light = { type = 'directional', intensity = 6 }, transform = { look_at = {-0.4, -0.7, "
    "-0.9} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 55 }, transform = { position = {%.6f, 1, 1.6}, look_at = {%.6f, "
    "0.6, -0.6} } }\n";

static image seen_from(double x, const char *view)
{
    char span[64], resolution[64], cascades[64];
    snprintf(span, sizeof span, "voxels.span=%g", SPAN);
    snprintf(resolution, sizeof resolution, "voxels.resolution=%d", RESOLUTION);
    snprintf(cascades, sizeof cascades, "voxels.cascades=%d", CASCADES);
    image_render(image_scenario("hall.lua", hall, x, x + 3), "--frames", "1", "--set", span, "--set",
                 resolution, "--set", cascades, "--set", "light.bounces=2", "--set", "view.channel=cascade",
                 "--view", view, "--out", image_path("hall.png"));
    return image_read("hall.png");
}

static image_error step_from(double x, const char *view)
{
    image before = seen_from(x, view), after = seen_from(x + MILLIMETRE, view);
    image_error e = image_difference(before, after);
    image_free(&before);
    image_free(&after);
    return e;
}

/* The cascades' centre goes before the camera by half of half the finest one's edge, and by whole dense cells
 * of the outermost: 16 cm of the hall then change from one size of voxels to another, which here, an arm's
 * length from the camera, is a tenth of the picture. Light there differs by 2 %. */
static void pictures_hardly_change_when_cascades_move(void **state)
{
    (void)state;
    double snap = SPAN * (1 << (CASCADES - 1)) * RESOLUTION / 64;
    double along = 3 / sqrt(3 * 3 + 0.4 * 0.4 + 2.2 * 2.2), ahead = 0.5 * 0.5 * RESOLUTION * SPAN * along;
    double border = (floor(ahead / snap) + 0.5) * snap - ahead, at = border - 0.5 * MILLIMETRE;
    double still = border + 0.4 * snap;
    assert_double_above(step_from(at, "lookup").mean, 0.01); /* they do move there */
    image_error across = step_from(at, "final"), elsewhere = step_from(still, "final");
    printf("across: mean %g, p99 %g; elsewhere: mean %g, p99 %g\n", across.mean, across.p99, elsewhere.mean,
           elsewhere.p99);
    assert_double_below(elsewhere.mean, 0.001);
    assert_double_below(across.mean, 0.7 / 255); /* less than a step of eight bits */
    assert_double_below(across.p99, 8.0 / 255);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_hardly_change_when_cascades_move),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
