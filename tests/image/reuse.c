/* Light that was traced in the frame before stands in for half of this frame's. That must not be seen, and
 * where light changes nothing may stay behind. */
#include "tests/image_fixture.h"

/* A room open to the front with a lamp and a glowing box that leaves in frame 12, when it is told to. The
 * camera slides along by `slide` a frame. */
static const char room[] =
    "kandil.scene { size = {64, 36}, fps = 10 }\n"
    "local function box(size, position, color)\n"
    "    return kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = position },\n"
    "                          material = { base_color = color } }\n"
    "end\n"
    "box({2.4, 0.2, 2.2}, {0, -0.1, 0}, {0.7, 0.7, 0.7})\n"
    "box({2.4, 1.8, 0.2}, {0, 0.9, -1}, {0.7, 0.7, 0.7})\n"
    "box({0.2, 1.8, 2}, {-1.1, 0.9, 0}, {0.7, 0.06, 0.05})\n"
    "box({0.4, 0.6, 0.4}, {-0.3, 0.3, -0.3}, {0.7, 0.7, 0.7})\n"
    "local glow = kandil.spawn { mesh = { shape = 'box', size = 0.16 }, transform = { position = {0.5, 0.9, "
    "-0.2} },\n"
    "                            material = { base_color = {1, 1, 1}, emissive = {20, 16, 12} } }\n"
    "kandil.spawn { light = { type = 'point', intensity = 0.5 }, transform = { position = {0.3, 1.5, 0.3} } "
    "}\n"
    "local eye = kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0.95, 3.4} } }\n"
    "function kandil.update(t)\n"
    "    if %d == 1 and t > 1.15 then glow.transform.position = {0, -40, 0} end\n"
    "    eye.transform.position = {%g * t * 10, 0.95, 3.4}\n"
    "end\n";

/* Renders frames 0 … count - 1 to PREFIX00.exr and so on. */
static void render(bool leaves, double slide, const char *reuse, const char *count, const char *prefix)
{
    char pattern[64];
    snprintf(pattern, sizeof pattern, "%s%%02d.exr", prefix);
    image_render(image_scenario("reuse.lua", room, leaves, slide), "--frames", count, "--view", "indirect",
                 "--set", reuse, "--set", "voxels.cascades=2", "--set", "voxels.span=0.04", "--set",
                 "cones.counters=on", "--stats", image_path("stats.json"), "--out", image_path(pattern));
}

static double mean(const char *name)
{
    image p = image_read(name);
    double m = image_mean_all(p);
    image_free(&p);
    return m;
}

static image_error difference(const char *a, const char *b)
{
    image p = image_read(a), q = image_read(b);
    image_error e = image_difference(p, q);
    image_free(&p);
    image_free(&q);
    return e;
}

/* Pixels traced in the last frame that was rendered. */
static double traced(void)
{
    static char text[65536];
    FILE *file = fopen(image_path("stats.json"), "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    const char *cones = strstr(text, "\"cones\"");
    assert_non_null(cones);
    const char *count = strstr(cones, "\"traced\":");
    assert_non_null(count);
    return strtod(count + strlen("\"traced\":"), NULL);
}

static void a_still_picture_stays_and_is_the_one_without(void **state)
{
    (void)state;
    render(false, 0, "cones.reuse=0", "60", "all");
    double all = traced();
    render(false, 0, "cones.reuse=2", "60", "half");
    assert_double_above(traced(), 0);
    assert_double_below(traced(), 0.6 * all);
    assert_double_near(difference("half58.exr", "half59.exr").max, 0, 0);
    assert_double_near(difference("half59.exr", "all59.exr").max, 0, 0);
}

static void a_moving_camera_sees_the_same(void **state)
{
    (void)state;
    render(false, 0.002, "cones.reuse=0", "12", "all");
    double all = traced();
    render(false, 0.002, "cones.reuse=4", "12", "some");
    assert_double_below(traced(), 0.8 * all);
    assert_double_below(difference("all11.exr", "some11.exr").mean, 0.02 * mean("all11.exr"));
}

static void what_glows_takes_its_light_along(void **state)
{
    (void)state;
    render(true, 0, "cones.reuse=4", "40", "left");
    double lit = mean("left11.exr"), left = mean("left39.exr"), all = lit - left;
    assert_double_above(lit, 1.5 * left);
    assert_double_near(mean("left12.exr"), left, 0.1 * all);
    /* Nothing of it stays; the lamp's light has begun anew and gains a bounce in some frames. */
    assert_double_below(mean("left14.exr"), left + 0.01 * all);
    assert_double_above(mean("left14.exr"), left - 0.03 * all);
    assert_double_below(mean("left22.exr"), left + 0.001 * all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_still_picture_stays_and_is_the_one_without),
                                       cmocka_unit_test(a_moving_camera_sees_the_same),
                                       cmocka_unit_test(what_glows_takes_its_light_along)};
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
