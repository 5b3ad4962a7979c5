/* A closed dark room in a bright world stays dark, however it is turned against the voxels. */

#include "tests/image_fixture.h"

enum { TURNS = 64 };

/* 30 voxels inside, walls of one voxel, all on one entity that is turned anew in every frame. The camera
 * looks from the opposite side of the middle into one of the eight corners after the other. Outside the sky's
 * radiance is 1, and a sun makes white walls that face it as bright. */
static const char scene[] =
    "kandil.scene { size = {24, 18} }\n"
    "local WALL, INSIDE = 0.02, 0.6\n"
    "local room = kandil.spawn { transform = {} }\n"
    "for axis = 1, 3 do\n"
    "    for side = -1, 1, 2 do\n"
    "        local size, place = {INSIDE + 2 * WALL, INSIDE + 2 * WALL, INSIDE + 2 * WALL}, {0, 0, 0}\n"
    "        size[axis], place[axis] = WALL, (INSIDE + WALL) / 2 * side\n"
    "        kandil.spawn { parent = room, mesh = { shape = 'box', size = size }, transform = { position = "
    "place },\n"
    "                       material = { base_color = {0.7, 0.7, 0.7} } }\n"
    "    end\n"
    "end\n"
    "local camera = kandil.spawn { parent = room, camera = { fov_y_deg = 90 }, transform = {} }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3.14159 }, transform = { look_at = {-0.4, "
    "-1, "
    "-0.5} } }\n"
    "local turn = 0\n"
    "function kandil.update()\n"
    "    turn = turn + 1\n"
    "    local x, y, z = turn % 2 * 2 - 1, turn // 2 % 2 * 2 - 1, turn // 4 % 2 * 2 - 1\n"
    "    room.transform.rotation_deg = {turn * 37.7 % 360, turn * 61.3 % 360, turn * 22.9 % 360}\n"
    "    camera:set('transform.position', {-0.2 * x, -0.2 * y, -0.2 * z})\n"
    "    camera:look_at({x, y, z})\n"
    "end\n";

typedef struct leakage {
    double mean, worst, brightest; /* of all pictures; the mean of the worst one; of one pixel */
} leakage;

/* Render the room in all its turns: `light.bounces=1` lets every frame stand for itself. */
static leakage render(const char *leak)
{
    char setting[32], name[16];
    leakage all = {0};
    snprintf(setting, sizeof setting, "light.leak=%s", leak);
    image_render(image_scenario("turned.lua", "%s", scene), "--frames", "64", "--set", setting, "--set",
                 "light.bounces=1", "--set", "light.ambient=1", "--set", "voxels.span=0.02", "--set",
                 "voxels.cascades=1", "--out", image_path("%04d.exr"));
    for (int i = 0; i < TURNS; i++) {
        snprintf(name, sizeof name, "%04d.exr", i);
        image p = image_read(name);
        double mean = image_mean_all(p);
        all.mean += mean / TURNS;
        all.worst = fmax(all.worst, mean);
        for (size_t k = 0; k < image_count(p); k++)
            all.brightest = fmax(all.brightest, (double)p.rgb[k]);
        image_free(&p);
    }
    if (getenv("KD_KEEP_PICTURES"))
        print_message("%s: mean %.5f, worst %.5f, brightest %.5f\n", leak, all.mean, all.worst,
                      all.brightest);
    return all;
}

/* Through walls as thin as a voxel some light gets in: what is held here is that it grows no more. */
static void thin_walls_let_little_in(void **state)
{
    (void)state;
    leakage l = render("default");
    assert_double_below(l.mean, 0.018);
    assert_double_below(l.worst, 0.025);
    assert_double_above(l.mean, 0.001); /* or nothing below would be shown */
}

static void strictly_a_thousandth(void **state)
{
    (void)state;
    leakage l = render("strict");
    assert_double_below(l.mean, 0.0005);
    assert_double_below(l.worst, 0.001);
}

/* Strictness hides light of thin walls alone: a thick floor beside a thick wall keeps what it sends out. */
static void thick_walls_still_light_each_other(void **state)
{
    static const char corner[] =
        "kandil.scene { size = {24, 18} }\n"
        "kandil.spawn { mesh = { shape = 'box', size = {2, 0.5, 2} }, transform = { position = {0, -0.25, 0} "
        "},\n"
        "               material = { base_color = {0.7, 0.7, 0.7} } }\n"
        "kandil.spawn { mesh = { shape = 'box', size = {0.5, 1, 2} }, transform = { position = {-0.75, 0.5, "
        "0} },\n"
        "               material = { base_color = {0.7, 0.7, 0.7} } }\n"
        "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {-0.2, -1, "
        "0} } }\n"
        "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0.6, 0.5, 0}, look_at = "
        "{-0.5, 0.2, 0} } }\n";
    static const char *const leaks[] = {"light.leak=default", "light.leak=strict"};
    double mean[2];
    (void)state;
    for (int i = 0; i < 2; i++) {
        image_render(image_scenario("corner.lua", "%s", corner), "--frames", "1", "--set", leaks[i], "--set",
                     "light.bounces=1", "--view", "indirect", "--out", image_path("corner.exr"));
        image p = image_read("corner.exr");
        mean[i] = image_mean_all(p);
        image_free(&p);
    }
    if (getenv("KD_KEEP_PICTURES"))
        print_message("corner: default %.4f, strict %.4f\n", mean[0], mean[1]);
    assert_double_above(mean[1], 0.5 * mean[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(thin_walls_let_little_in),
        cmocka_unit_test(strictly_a_thousandth),
        cmocka_unit_test(thick_walls_still_light_each_other),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
