/* Light that is reflected again and again, in a closed room whose walls all glow with 1 and reflect a share
 * of 0.6: what a wall sends out is a geometric series, whatever the room's shape. */
#include "tests/image_fixture.h"

#define ALBEDO 0.6

static const char room[] =
    "kandil.scene { size = {32, 24}, fps = 10 }\n"
    "local walls = {}\n"
    "for axis = 1, 3 do\n"
    "    for side = -1, 1, 2 do\n"
    "        local size, place = {2.6, 2.6, 2.6}, {0, 0, 0}\n"
    "        size[axis], place[axis] = 0.3, side * 1.15\n"
    "        walls[#walls + 1] = kandil.spawn { mesh = { shape = 'box', size = size }, transform = { "
    "position = place },\n"
    "            material = { base_color = {0.6, 0.6, 0.6}, emissive = {%g, %g, %g} } }\n"
    "    end\n"
    "end\n"
    "local lamp = kandil.spawn { light = { type = 'point', intensity = %g }, transform = { position = {0.2, "
    "0.3, 0} } }\n"
    "function kandil.update(t) if t > 1.15 then lamp.light.intensity = 0 end end\n"
    "kandil.spawn { camera = { fov_y_deg = 60, z_near = 0.01 },\n"
    "               transform = { position = {0.1, 0, 0.2}, look_at = {0.3, 0.1, -1} } }\n";

static void render(double glow, double lamp, const char *bounces, const char *frames, const char *view)
{
    image_render(image_scenario("room.lua", room, glow, glow, glow, lamp), "--frames", frames, "--set",
                 bounces, "--set", "voxels.cascades=2", "--view", view, "--out", image_path("room%02d.exr"));
}

/* Of one frame of the last run. */
static double mean_of(int frame)
{
    char name[32];
    snprintf(name, sizeof name, "room%02d.exr", frame);
    image p = image_read(name);
    double m = image_mean_all(p);
    image_free(&p);
    return m;
}

/* Of the last of so many frames. */
static double mean(double glow, double lamp, const char *bounces, const char *frames, const char *view)
{
    render(glow, lamp, bounces, frames, view);
    return mean_of(atoi(frames) - 1);
}

/* The rough surface's highlight adds about 1 % of what arrives. */
static void bounces_are_a_geometric_series(void **state)
{
    (void)state;
    const double a = ALBEDO;
    double one = mean(1, 0, "light.bounces=1", "1", "final"),
           two = mean(1, 0, "light.bounces=2", "1", "final");
    if (getenv("KD_KEEP_PICTURES"))
        print_message("1: %.3f of %.3f, 2: %.3f of %.3f\n", one, 1 + a, two, 1 + a + a * a);
    assert_double_near(one / (1 + a), 1, 0.03);
    assert_double_near(two / (1 + a + a * a), 1, 0.04);
}

/* Every frame adds light of one more bounce, and all of them stay below what there can be, which they reach.
 */
static void light_grows_to_its_limit_and_not_beyond(void **state)
{
    (void)state;
    const double limit = 1 / (1 - ALBEDO);
    double before = 0;
    render(1, 0, "light.bounces=inf", "40", "final");
    for (int i = 0; i < 40; i++) {
        double now = mean_of(i);
        assert_double_above(now, before * 0.999);
        assert_double_below(now, 1.05 * limit);
        before = now;
    }
    if (getenv("KD_KEEP_PICTURES"))
        print_message("inf: %.3f of %.3f\n", before, limit);
    assert_double_near(before / limit, 1, 0.065); /* three walls lie in the second cascade */
}

/* A lamp goes out in frame 12, when its light has gone round for long. */
static void light_leaves_with_its_lamp(void **state)
{
    (void)state;
    double once = mean(0, 5, "light.bounces=1", "12", "indirect");
    render(0, 5, "light.bounces=inf", "23", "indirect");
    double lit = mean_of(11);
    assert_double_above(lit, 1.3 * once);
    assert_double_below(mean_of(12), 0.1 * lit);
    assert_double_below(mean_of(14), 0.01 * lit);
    assert_double_near(mean_of(22), 0, 0);
}

/* Without bounces only what shines is seen, straight or in the light that it throws. */
static void no_bounces_leave_what_shines(void **state)
{
    (void)state;
    assert_double_near(mean(0, 5, "light.bounces=0", "2", "indirect"), 0, 0);
    assert_double_near(mean(1, 0, "light.bounces=0", "2", "final") / (1 + ALBEDO), 1, 0.03);
}

/* Among many things that are small beside the voxels most samples meet next to nothing. What bounces there
 * settles like everywhere: half of the frames later it is what it was. */
static void light_does_not_grow_among_small_things(void **state)
{
    static const char field[] =
        "kandil.scene { size = {64, 36}, fps = 24, settings = { ['voxels.span'] = 0.5 } }\n"
        "local grey = { base_color = {0.8, 0.8, 0.8} }\n"
        "kandil.spawn { mesh = { shape = 'plane', size = {600, 1, 600} }, material = grey }\n"
        "for i = -10, 10 do\n"
        "    for k = -10, 10 do\n"
        "        kandil.spawn { mesh = { shape = 'torus', size = {6, 2, 6} }, material = grey,\n"
        "                       transform = { position = {i * 9.3 + 0.37 * k, 2.3 + 0.1 * i, k * 8.7},\n"
        "                                     rotation_deg = {13 * i, 29 * k, 7 * i} } }\n"
        "    end\n"
        "end\n"
        "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {0.3, -1, "
        "-0.4} } }\n"
        "kandil.spawn { camera = { z_far = 1000 }, transform = { position = {2, 8, 40}, look_at = {0, 3, 0} "
        "} }\n";
    (void)state;
    image_render(image_scenario("field.lua", "%s", field), "--frames", "32", "--view", "indirect", "--out",
                 image_path("field_%02d.exr"));
    image early = image_read("field_15.exr"), late = image_read("field_31.exr");
    assert_double_above(image_mean_all(early), 0.05);
    assert_double_near(image_mean_all(late), image_mean_all(early), 0.03 * image_mean_all(early));
    image_free(&early);
    image_free(&late);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounces_are_a_geometric_series),
        cmocka_unit_test(light_grows_to_its_limit_and_not_beyond),
        cmocka_unit_test(light_leaves_with_its_lamp),
        cmocka_unit_test(no_bounces_leave_what_shines),
        cmocka_unit_test(light_does_not_grow_among_small_things),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
