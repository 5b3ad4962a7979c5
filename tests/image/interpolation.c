/* The forms of sampling that cones can have (`cones.interpolation`), and sets of few and of many cones. */
#include "tests/image_fixture.h"

#define ALBEDO 0.5
/* As in furnace.c: what walls send out, what one bounce brings, and what their Fresnel reflection adds. */
#define RADIANCE (1 + ALBEDO + 0.01)

/* A closed room 50 voxels wide whose walls glow and reflect alike: every pixel has the same radiance. */
static const char furnace[] =
    "kandil.scene { size = {24, 18} }\n"
    "for axis = 1, 3 do\n"
    "    for side = -1, 1, 2 do\n"
    "        local size, place = {2.6, 2.6, 2.6}, {0, 0, 0}\n"
    "        size[axis], place[axis] = 0.3, side * 1.15\n"
    "        kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = place },\n"
    "                       material = { base_color = {%g, %g, %g}, emissive = {1, 1, 1} } }\n"
    "    end\n"
    "end\n"
    "kandil.spawn { camera = { fov_y_deg = 60, z_near = 0.01 },\n"
    "               transform = { position = {0.1, 0, 0.2}, look_at = {0.3, 0.1, -1} } }\n";

/* A room open to the front with a lamp, a coloured wall and a block. */
static const char lit_room[] =
    "kandil.scene { size = {48, 27} }\n"
    "local function box(size, position, color)\n"
    "    kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = position },\n"
    "                   material = { base_color = color } }\n"
    "end\n"
    "box({2.4, 0.2, 2.2}, {0, -0.1, 0}, {0.7, 0.7, 0.7})\n"
    "box({2.4, 0.2, 2.2}, {0, 1.9, 0}, {0.7, 0.7, 0.7})\n"
    "box({2.4, 1.8, 0.2}, {0, 0.9, -1}, {0.7, 0.7, 0.7})\n"
    "box({0.2, 1.8, 2}, {-1.1, 0.9, 0}, {0.7, 0.06, 0.05})\n"
    "box({0.2, 1.8, 2}, {1.1, 0.9, 0}, {0.1, 0.6, 0.1})\n"
    "box({0.4, 0.6, 0.4}, {-0.3, 0.3, -0.3}, {0.7, 0.7, 0.7})\n"
    "kandil.spawn { light = { type = 'point', intensity = 0.5 }, transform = { position = {0.3, 1.5, 0.3} } "
    "}\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0.95, 3.4} } }\n";

static const char *const modes[] = {"trilinear", "quadrilinear", "paper"};
enum { TRILINEAR, QUADRILINEAR, PAPER, MODES };

static image render(const char *scene, const char *mode, int cones, const char *view)
{
    char interpolation[64], count[32];
    snprintf(interpolation, sizeof interpolation, "cones.interpolation=%s", mode);
    snprintf(count, sizeof count, "cones.count=%d", cones);
    image_render(scene, "--frames", "1", "--gi", "cones", "--view", view, "--set", "light.bounces=1", "--set",
                 "voxels.span=0.04", "--set", "voxels.cascades=1", "--set", interpolation, "--set", count,
                 "--set", "cones.resolution=1", "--out", image_path("shown.exr"));
    return image_read("shown.exr");
}

/* limit: of a pixel's deviation, relative; their mean is within 3 % always. */
static void check_furnace(const char *mode, int cones, double limit)
{
    image p = render(image_scenario("furnace.lua", furnace, ALBEDO, ALBEDO, ALBEDO), mode, cones, "final");
    double worst = 0, mean = image_mean_all(p);
    for (size_t i = 0; i < image_count(p); i++)
        worst = fmax(worst, fabs((double)p.rgb[i] - RADIANCE));
    if (worst > limit * RADIANCE || getenv("KD_KEEP_PICTURES"))
        print_message("%s, %d cones: mean %.4f, off by %.2f %% at most\n", mode, cones, mean,
                      100 * worst / RADIANCE);
    assert_double_near(mean, RADIANCE, 0.03 * RADIANCE);
    assert_double_below(worst, limit * RADIANCE);
    image_free(&p);
}

static void every_form_keeps_a_furnace(void **state)
{
    (void)state;
    check_furnace(modes[QUADRILINEAR], 6, 0.03);
    check_furnace(modes[PAPER], 6, 0.035);
}

static void few_cones_and_many_keep_a_furnace(void **state)
{
    (void)state;
    for (int cones = 3; cones <= 9; cones++)
        check_furnace(modes[TRILINEAR], cones, cones == 4 ? 0.02 : 0.035);
    check_furnace(modes[PAPER], 3, 0.03);
    check_furnace(modes[PAPER], 9, 0.06);
}

static void forms_differ_little_in_a_lit_room(void **state)
{
    (void)state;
    image a = render(image_scenario("room.lua", "%s", lit_room), modes[TRILINEAR], 4, "indirect");
    double of_a = image_mean_all(a);
    assert_double_above(of_a, 0);
    for (int mode = QUADRILINEAR; mode < MODES; mode++) {
        image b = render(image_path("room.lua"), modes[mode], 4, "indirect");
        double pixels = image_difference(a, b).mean / of_a;
        assert_double_near(image_mean_all(b), of_a, 0.1 * of_a);
        assert_double_above(pixels, 1e-4); /* it is another form */
        image_free(&b);
    }
    image_free(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_form_keeps_a_furnace),
        cmocka_unit_test(few_cones_and_many_keep_a_furnace),
        cmocka_unit_test(forms_differ_little_in_a_lit_room),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
