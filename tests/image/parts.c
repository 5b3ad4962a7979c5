/* Entities as scenarios reach them: a shape is one entity that carries its mesh itself, and a model stands
 * still until its scenario lets it play. */
#include "tests/image_fixture.h"

/* A box floats above a floor that a sun lights straight from above; the camera looks from the side, low under
 * the box. */
static const char floating_box[] =
    "kandil.scene { size = {64, 36}, gi = 'none' }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {4, 0.2, 4} }, transform = { position = {0, -0.1, 0} } }\n"
    "local box = kandil.spawn { name = 'box', mesh = { shape = 'box', size = 0.5 }, %s\n"
    "                           transform = { position = {0, 1.2, 0} } }\n"
    "%s\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {0, -1, 0.001} "
    "} }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0.6, 3}, look_at = {0, 0.2, 0} "
    "} }\n";

/* Mean of the floor under the box, where its shadow falls: it lies 10.5 to 12.3 degrees below the horizon,
 * the picture's middle 7.6, and 40 degrees are 36 rows: rows 20.6 to 22.2. */
static double under_the_box(const char *spawn, const char *later)
{
    image_render(image_scenario("floating.lua", floating_box, spawn, later), "--frames", "1", "--out",
                 image_path("floating.exr"));
    image p = image_read("floating.exr");
    double mean = image_mean(p, 0, 30, 21, 34, 22);
    image_free(&p);
    return mean;
}

static void a_shape_takes_flags_of_its_mesh(void **state)
{
    (void)state;
    double shadow = under_the_box("", "");
    double spawned = under_the_box("mesh_instance = { no_shadow = true },", "");
    double set_later = under_the_box("", "box:set('mesh_instance.no_shadow', true)");
    double hidden = under_the_box("", "box:set('mesh_instance.hidden', true)");
    assert_true(shadow < 0.05);
    assert_true(hidden > 0.2);
    assert_double_near(spawned, hidden, 1e-3);
    assert_double_near(set_later, hidden, 1e-3);
}

/* The sample creature's walk moves its feet within a quarter of a second. */
static image walker_after(const char *animation, const char *output)
{
    image_render(
        image_scenario("walker.lua",
                       "kandil.scene { size = {64, 36}, gi = 'none', fps = 24 }\n"
                       "kandil.spawn { model = 'walker.gltf', %s }\n"
                       "kandil.spawn { light = { intensity = 3 }, transform = { look_at = {0, -1, -1} } }\n"
                       "kandil.spawn { camera = { fov_y_deg = 30 },\n"
                       "               transform = { position = {1, 0.6, 2}, look_at = {0, 0.4, 0} } }\n",
                       animation),
        "--frames", output[0] == 'a' ? "1" : "7", "--asset-root", KD_SOURCE_DIR "/samples/assets", "--out",
        image_path(output));
    return image_read(output);
}

static bool equal(image a, image b)
{
    return memcmp(a.rgb, b.rgb, sizeof(float) * 3 * a.width * a.height) == 0;
}

static void a_model_plays_when_told_to(void **state)
{
    (void)state;
    image still_first = walker_after("", "a_still.png"), still_later = walker_after("", "b_still.png");
    image walk_first = walker_after("animation = { clip = 'walk' }", "a_walk.png");
    image walk_later = walker_after("animation = { clip = 'walk' }", "b_walk.png");
    assert_true(equal(still_first, still_later));
    assert_false(equal(walk_first, walk_later));
    image_free(&still_first);
    image_free(&still_later);
    image_free(&walk_first);
    image_free(&walk_later);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_shape_takes_flags_of_its_mesh),
        cmocka_unit_test(a_model_plays_when_told_to),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
