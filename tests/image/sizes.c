/* Pictures of every shape, and every view. */

#include "tests/image_fixture.h"

/* Something for every view to show: near and far, coloured, slanted, lit and shadowed. */
static const char scene[] =
    "kandil.scene { size = {96, 54}, fps = 10, seconds = 1 }\n"
    "kandil.spawn { mesh = { shape = 'plane', size = {6, 1, 6} }, material = { base_color = {0.7, 0.7, 0.7} "
    "} }\n"
    "kandil.spawn { mesh = { shape = 'box', size = 0.6 }, material = { base_color = {0.8, 0.2, 0.1} },\n"
    "               transform = { position = {0, 0.3, 0}, rotation_deg = {0, 30, 0} } }\n"
    "kandil.spawn { mesh = { shape = 'sphere', size = 0.6 }, material = { metallic = 1, roughness = 0.2 },\n"
    "               transform = { position = {0.7, 0.3, 0.3} } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {-0.4, -1, "
    "-0.5} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {1.4, 1.2, 2.2}, look_at = {0.2, "
    "0.3, 0} } }\n";

static image render(const char *size, const char *view, const char *output)
{
    image_render(image_scenario("things.lua", scene), "--frames", "1", "--size", size, "--view", view,
                 "--out", image_path(output));
    return image_read(output);
}

static void pictures_of_every_shape_come_out(void **state)
{
    static const struct {
        const char *text;
        uint32_t width, height;
    } sizes[] = {
        {"1x1", 1, 1}, {"7x5", 7, 5}, {"1921x1079", 1921, 1079}, {"4096x16", 4096, 16}, {"16x512", 16, 512}};
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const char *output = i % 2 ? "sized.exr" : "sized.png";
        image p = render(sizes[i].text, "final", output);
        assert_int_equal(p.width, sizes[i].width);
        assert_int_equal(p.height, sizes[i].height);
        assert_double_above(image_mean_all(p), 0.001); /* a very wide one is mostly background */
        if (p.width > 2)
            assert_false(image_is_constant(p));
        image_free(&p);
    }
}

/* The same scene in other sizes is the same picture: the middle of each pixel of the small one is a pixel of
 * one three times as large. Edges and the gather at every other pixel leave differences; means leave none. */
static void size_changes_only_the_sampling(void **state)
{
    (void)state;
    image small = render("96x54", "final", "small.png"), large = render("288x162", "final", "large.png");
    for (int c = 0; c < 3; c++)
        assert_double_near(image_mean(small, c, 0, 0, 96, 54), image_mean(large, c, 0, 0, 288, 162), 0.005);
    image_free(&small);
    image_free(&large);
}

static void every_view_shows_something(void **state)
{
    static const char *const views[] = {"final",  "direct", "indirect", "ao",     "specular", "albedo",
                                        "normal", "depth",  "light",    "caches", "octree",   "cost"};
    enum { COUNT = sizeof views / sizeof *views };
    image pictures[COUNT];
    (void)state;
    for (size_t i = 0; i < COUNT; i++) {
        pictures[i] = render("96x54", views[i], "view.png");
        if (image_is_constant(pictures[i]))
            fail_msg("view %s is of one colour", views[i]);
    }
    for (size_t i = 0; i < COUNT; i++)
        for (size_t k = 0; k < i; k++)
            if (image_difference(pictures[i], pictures[k]).mean < 1e-3)
                fail_msg("views %s and %s show the same", views[i], views[k]);
    for (size_t i = 0; i < COUNT; i++)
        image_free(&pictures[i]);
}

/* Views whose values can be told: the red box's front is all of its colour, the floor's normal points up,
 * depth grows away from the eye. */
static void views_show_what_they_say(void **state)
{
    (void)state;
    image albedo = render("96x54", "albedo", "albedo.exr"), normal = render("96x54", "normal", "normal.exr");
    image depth = render("96x54", "depth", "depth.exr"), direct = render("96x54", "direct", "direct.exr");
    image indirect = render("96x54", "indirect", "indirect.exr"),
          final = render("96x54", "final", "final.exr");
    const float *floor_albedo = image_at(albedo, 48, 50), *floor_normal = image_at(normal, 48, 50);
    for (int c = 0; c < 3; c++)
        assert_double_near((double)floor_albedo[c], 0.7, 0.005);
    assert_double_near((double)floor_normal[0], 0.5, 0.01);
    assert_double_near((double)floor_normal[1], 1.0, 0.01);
    assert_double_above((double)*image_at(depth, 10, 24), (double)*image_at(depth, 10, 50) + 0.5);
    for (size_t i = 0; i < image_count(final); i++) /* a sum of halfs: the last of 11 bits, twice */
        assert_double_near((double) final.rgb[i], (double)direct.rgb[i] + (double)indirect.rgb[i],
                           1e-4 + (double) final.rgb[i] / 512);
    image_free(&albedo);
    image_free(&normal);
    image_free(&depth);
    image_free(&direct);
    image_free(&indirect);
    image_free(&final);
}

/* Text of the statistics of a frame. */
static char *statistics(const char *setting)
{
    void *text;
    size_t size;
    image_render(image_scenario("things.lua", scene), "--frames", "1", "--size", "32x18", "--set", setting,
                 "--stats", image_path("stats.json"));
    assert_int_equal(kd_file_read(image_path("stats.json"), KD_FILE_NO_LIMIT, &text, &size), KD_OK);
    return text;
}

static void statistics_hold_the_samples_of_cones_that_were_counted(void **state)
{
    (void)state;
    char *counted = statistics("cones.counters=on"), *plain = statistics("cones.counters=off");
    const char *cones = strstr(counted, "\"cones\": {"), *each = cones;
    uint64_t of_all = 0, samples = 0;
    int count = 0;
    assert_non_null(cones);
    assert_null(strstr(plain, "\"cones\": {"));
    for (; (each = strstr(each, "\"samples\": ")) != NULL; each++, count++) {
        samples = strtoull(each + strlen("\"samples\": "), NULL, 10);
        of_all = count == 0 ? samples : of_all - samples;
    }
    assert_int_equal(count, 1 + 6 + 1 + 1); /* all, six diffuse ones, those to emitters, the glossy one */
    assert_int_equal(of_all, 0);
    free(counted);
    free(plain);
}

static void the_octree_has_levels(void **state)
{
    (void)state;
    image_render(image_scenario("things.lua", scene), "--frames", "1", "--view", "octree", "--out",
                 image_path("fine.png"));
    image_render(image_scenario("things.lua", scene), "--frames", "1", "--view", "octree", "--level", "4",
                 "--out", image_path("coarse.png"));
    image fine = image_read("fine.png"), coarse = image_read("coarse.png");
    assert_false(image_is_constant(coarse));
    assert_double_above(image_difference(fine, coarse).mean, 0.005);
    image_free(&fine);
    image_free(&coarse);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_of_every_shape_come_out),
        cmocka_unit_test(size_changes_only_the_sampling),
        cmocka_unit_test(every_view_shows_something),
        cmocka_unit_test(views_show_what_they_say),
        cmocka_unit_test(statistics_hold_the_samples_of_cones_that_were_counted),
        cmocka_unit_test(the_octree_has_levels),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
