/* The path tracer against linear pictures of the same files by another one (Cycles), made with ideally
 * diffuse materials lit from both sides. Ours are smaller, and theirs are averaged over the same areas.
 * Without the pictures the test is skipped.
 *
 * Noise sets the bounds, 1 % where it is bright, 4 % in the dark that few paths light: a region is a
 * sixteenth of the picture, some 500 of our pixels with a hundred samples or more each, whose mean is known
 * to a few tenths of a per cent; a pixel alone to some per cent, the square of which is what relMSE adds up.
 */

#include "tests/image_fixture.h"

#define ASSETS KD_SOURCE_DIR "/../shared/assets/"

/* The mean over each block of factor x factor pixels. */
static image shrunk(image p, uint32_t factor)
{
    image s = {p.width / factor, p.height / factor,
               calloc((size_t)(p.width / factor) * (p.height / factor) * 3, 4)};
    assert_non_null(s.rgb);
    for (uint32_t y = 0; y < s.height; y++)
        for (uint32_t x = 0; x < s.width; x++)
            for (int c = 0; c < 3; c++)
                s.rgb[((size_t)y * s.width + x) * 3 + (size_t)c] =
                    (float)image_mean(p, c, x * factor, y * factor, (x + 1) * factor, (y + 1) * factor);
    return s;
}

static double relative_mse(image test, image truth)
{
    double sum = 0;
    for (size_t i = 0; i < image_count(truth); i++) {
        double t = (double)test.rgb[i], r = (double)truth.rgb[i];
        sum += (t - r) * (t - r) / (r * r + 0.01);
    }
    return sum / (double)image_count(truth);
}

static double region(image p, uint32_t i)
{
    uint32_t x0 = i % 4 * p.width / 4, x1 = (i % 4 + 1) * p.width / 4;
    uint32_t y0 = i / 4 * p.height / 4, y1 = (i / 4 + 1) * p.height / 4;
    return (image_mean(p, 0, x0, y0, x1, y1) + image_mean(p, 1, x0, y0, x1, y1) +
            image_mean(p, 2, x0, y0, x1, y1)) /
           3;
}

static void expect_truth(image test, const char *name)
{
    char path[512];
    snprintf(path, sizeof path, ASSETS "truth/%s", name);
    image whole = image_read_exr(path), truth = shrunk(whole, whole.width / test.width);
    double mean = image_mean_all(truth), error = relative_mse(test, truth);
    assert_int_equal(truth.width, test.width);
    assert_int_equal(truth.height, test.height);
    for (uint32_t i = 0; i < 16; i++) {
        double a = region(test, i), b = region(truth, i), tolerance = b > 0.4 * mean ? 0.01 : 0.04;
        if (b > 0.1 * mean && !(fabs(a / b - 1) <= tolerance))
            fail_msg("%s: region %u %u has %g of the light", name, i % 4, i / 4, a / b);
    }
    if (!(error <= 0.01))
        fail_msg("%s: relMSE is %g", name, error);
    image_free(&whole);
    image_free(&truth);
}

static image trace(const char *scene, const char *size, const char *spp, const char *bounces)
{
    if (image_kandil("reference", scene, "--asset-root", ASSETS, "--size", size, "--spp", spp, "--bounces",
                     bounces, "--lambert", "--out", image_path("traced.exr"), "--quiet") != 0)
        fail_msg("%s", image_message);
    return image_read("traced.exr");
}

static void cornell_box_agrees_after_any_bounces(void **state)
{
    static const struct {
        const char *bounces, *truth;
    } cases[] = {{"0", "cornell_0.exr"}, {"1", "cornell_1.exr"}, {"16", "cornell_16.exr"}};
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        image p = trace(ASSETS "cornell_box/cornell_box.glb", "96x96", "192", cases[i].bounces);
        expect_truth(p, cases[i].truth);
        image_free(&p);
    }
}

/* The sky is white in our settings. Light adds up, so a picture under a sky of 1, with the sun over the sky's
 * colour, times the sky's colour is the picture asked for. */
static const char sponza[] =
    "kandil.scene { settings = { ['light.ambient'] = 1 } }\n"
    "kandil.spawn { model = 'sponza/sponza.glb' }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 12, color = {1 / 0.5, 0.95 / 0.6, 0.85 / "
    "0.8} },\n"
    "               transform = { look_at = {0.18, -1, 0.28} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 55, z_near = 0.01 },\n"
    "               transform = { position = {-10.5, 1.9, -0.4}, look_at = {4, 3.2, 0.2} } }\n";

static void sponza_agrees_after_any_bounces(void **state)
{
    static const float sky[3] = {0.5f, 0.6f, 0.8f};
    static const struct {
        const char *bounces, *truth;
    } cases[] = {{"1", "sponza_1.exr"}, {"8", "sponza_8.exr"}};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        image p = trace(image_scenario("sponza.lua", "%s", sponza), "96x54", "256", cases[i].bounces);
        for (size_t k = 0; k < image_count(p); k++)
            p.rgb[k] *= sky[k % 3];
        expect_truth(p, cases[i].truth);
        image_free(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cornell_box_agrees_after_any_bounces),
        cmocka_unit_test(sponza_agrees_after_any_bounces),
    };
    if (!kd_file_exists(ASSETS "truth/cornell_0.exr")) {
        fprintf(stderr, "skipped: %struth is not at hand\n", ASSETS);
        return 77;
    }
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
