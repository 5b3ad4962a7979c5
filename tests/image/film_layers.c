/* Files with layers hold what is known of their scenes: light that adds up, depth and normal of a wall, the
 * way of a box in pixels, and vertices that go back to where they were. */
#include <unistd.h>

#include "runtime/asset/exr_shim.h"
#include "tests/image_fixture.h"

/* Seen without perspective from 5 m away: 50 pixels a metre. A wall at z = 0, and a box before it whose front
 * is at z = 1 and that goes 0.1 m to the right and 0.04 m up a step. */
static const char scene[] =
    "kandil.scene { size = {160, 90}, fps = 10, gi = '%s' }\n"
    "kandil.set('voxels.span', 0.1)\n"
    "kandil.spawn { mesh = { shape = 'box', size = {12, 12, 1} }, transform = { position = {0, 0, -0.5} },\n"
    "               material = { base_color = {0.5, 0.25, 0.125, 1} } }\n"
    "local box = kandil.spawn { mesh = { shape = 'box', size = {1, 1, 0.5} },\n"
    "                           transform = { position = {-0.5, 0, 0.75} },\n"
    "                           material = { base_color = {0.25, 0.5, 1, 1}, emissive = {0, 0.5, 0} } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 2 }, transform = { look_at = {-0.3, -0.2, "
    "-1} } }\n"
    "local eye = kandil.spawn { camera = { orthographic = true, y_mag = 0.9 },\n"
    "                           transform = { position = {0, 0, 5} } }\n"
    "function kandil.update(t)\n"
    "    box.transform.position = {-0.5 + t, 0.4 * t, 0.75}\n"
    "    eye.transform.position = {%s, 0, 5}\n"
    "end\n";

enum { WIDTH = 160, HEIGHT = 90 };
/* Of frame 3: the box's middle is at x = -0.2, y = 0.12, which is pixel 80 - 10, 45 - 6; and a place on the
 * wall. */
static const uint32_t on_box[2] = {70, 39}, on_wall[2] = {140, 70};

typedef struct layers {
    void *data;
    size_t size;
} layers;

static layers open_layers(const char *name)
{
    layers l;
    assert_int_equal(kd_file_read(image_path(name), KD_FILE_NO_LIMIT, &l.data, &l.size), KD_OK);
    return l;
}

static float *channel(const layers *l, const char *name)
{
    uint32_t width, height;
    const char *error, *missing;
    float *values = exr_shim_planes(l->data, l->size, &name, 1, &width, &height, &error, &missing);
    if (!values || width != WIDTH || height != HEIGHT)
        fail_msg("no channel %s", name);
    return values;
}

static double value_at(const layers *l, const char *name, const uint32_t pixel[2])
{
    float *values = channel(l, name);
    double value = (double)values[pixel[1] * WIDTH + pixel[0]];
    free(values);
    return value;
}

#define RENDER(name, out, ...)                                                                               \
    image_render(image_path(name), "--frames", "4", "--out", image_path(out), __VA_ARGS__)

/* Half floats have eleven bits: each part is off by up to 1 in 2048 of it. */
static void assert_parts_add_up(const layers *l, char color)
{
    static const char *const parts[] = {"direct", "indirect", "emission", "blended"};
    char name[32] = {color, '\0'};
    float *final = channel(l, name), sum[WIDTH * HEIGHT] = {0};
    double brightest = 0;
    for (size_t p = 0; p < 4; p++) {
        snprintf(name, sizeof name, "%s.%c", parts[p], color);
        float *part = channel(l, name);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            sum[i] += part[i];
        free(part);
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_double_near((double)sum[i], (double) final[i], 0.002 * (double) final[i] + 1e-5);
        brightest = fmax(brightest, (double) final[i]);
    }
    assert_double_above(brightest, 0.1);
    free(final);
}

static void layers_are_those_of_the_scene(void **state)
{
    (void)state;
    image_scenario("known.lua", scene, "cones", "0");
    RENDER("known.lua", "known.exr", "--layers");
    layers l = open_layers("known.exr");
    for (const char *c = "RGB"; *c; c++)
        assert_parts_add_up(&l, *c);
    assert_double_near(value_at(&l, "emission.G", on_box), 0.5, 1e-3);
    assert_double_near(value_at(&l, "emission.R", on_box), 0, 1e-6);
    assert_double_above(value_at(&l, "indirect.G", on_wall), 1e-4);
    assert_double_near(value_at(&l, "Z", on_wall), 5, 1e-4);
    assert_double_near(value_at(&l, "Z", on_box), 4, 1e-4);
    assert_double_near(value_at(&l, "N.X", on_wall), 0, 1e-3);
    assert_double_near(value_at(&l, "N.Y", on_wall), 0, 1e-3);
    assert_double_near(value_at(&l, "N.Z", on_wall), 1, 1e-3);
    assert_double_near(value_at(&l, "albedo.R", on_wall), 0.5, 0.003);
    assert_double_near(value_at(&l, "albedo.B", on_wall), 0.125, 0.003);
    assert_double_near(value_at(&l, "albedo.B", on_box), 1, 0.003);
    /* to the right and up by 5 and 2 pixels a step: back is to the left and down, which is where y grows */
    assert_double_near(value_at(&l, "motion.X", on_box), -5, 0.02);
    assert_double_near(value_at(&l, "motion.Y", on_box), 2, 0.02);
    assert_double_near(value_at(&l, "motion.X", on_wall), 0, 1e-3);
    assert_double_near(value_at(&l, "motion.Y", on_wall), 0, 1e-3);
    free(l.data);
}

/* A camera that goes 0.02 m to the right takes everything one pixel to the left. */
static void motion_knows_the_camera(void **state)
{
    (void)state;
    image_scenario("eye.lua", scene, "none", "0.2 * t");
    RENDER("eye.lua", "eye.exr", "--layers", "--supersample", "2", "--subframes", "2");
    layers l = open_layers("eye.exr");
    assert_double_near(value_at(&l, "motion.X", on_wall), 1, 0.02);
    assert_double_near(value_at(&l, "motion.X", on_box), -4, 0.02);
    free(l.data);
}

/* Follow each pixel back to the frame before: what is found there lies where its surface was. A walking body
 * of one colour is told by its depth. */
static void deformed_surfaces_are_found_again(void **state)
{
    (void)state;
    image_scenario("walk.lua",
                   "kandil.scene { size = {160, 90}, fps = 12, gi = 'none' }\n"
                   "local w = kandil.spawn { model = 'walker.gltf', transform = { position = {0, 0, 0} } }\n"
                   "w:play('walk', { loop = true })\n"
                   "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {2, 1, 2.5}, "
                   "look_at = {0, 0.9, 0} } }\n");
    image_render(image_path("walk.lua"), "--frames", "5", "--layers", "--out", image_path("walk_%d.exr"),
                 "--asset-root", KD_SOURCE_DIR "/samples/assets");
    layers before = open_layers("walk_3.exr"), now = open_layers("walk_4.exr");
    float *z[2] = {channel(&before, "Z"), channel(&now, "Z")};
    float *x = channel(&now, "motion.X"), *y = channel(&now, "motion.Y");
    int body = 0, moved = 0, found = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int u = (int)lroundf((float)(i % WIDTH) + x[i]), v = (int)lroundf((float)(i / WIDTH) + y[i]);
        if (z[1][i] > 100 || u < 0 || v < 0 || u >= WIDTH || v >= HEIGHT)
            continue;
        body++;
        moved += hypotf(x[i], y[i]) > 0.5f;
        found += z[0][v * WIDTH + u] < 100;
    }
    assert_double_above(body, 300);
    assert_double_above(moved, 0.2 * body);
    assert_double_above(found, 0.97 * body); /* all but some pixels at the edges */
    free(z[0]);
    free(z[1]);
    free(x);
    free(y);
    free(before.data);
    free(now.data);
}

/* What is left out and rendered later knows where things were, too. */
static void resumed_layers_have_the_same_bytes(void **state)
{
    (void)state;
    image_scenario("resumed.lua", scene, "cones", "0");
    const char *const common[] = {"--layers", "--subframes", "3", "--set", "light.bounces=0"};
    RENDER("resumed.lua", "whole_%d.exr", common[0], common[1], common[2], common[3], common[4], "--frames",
           "7");
    RENDER("resumed.lua", "part_%d.exr", common[0], common[1], common[2], common[3], common[4], "--frames",
           "7");
    unlink(image_path("part_5.exr"));
    RENDER("resumed.lua", "part_%d.exr", common[0], common[1], common[2], common[3], common[4], "--frames",
           "7", "--resume");
    assert_same_file("whole_5.exr", "part_5.exr");
    assert_same_file("whole_6.exr", "part_6.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_are_those_of_the_scene),
        cmocka_unit_test(motion_knows_the_camera),
        cmocka_unit_test(deformed_surfaces_are_found_again),
        cmocka_unit_test(resumed_layers_have_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
