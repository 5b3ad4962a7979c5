/* Frames that are means: a moving box leaves a ramp of the right width, a picture of few pixels is the mean
 * of one of many, and what happens in the scene does not depend on how it is filmed. */
#include <unistd.h>

#include "tests/image_fixture.h"

/* 50 pixels a metre without perspective. A box that shines by itself, 1 m wide, goes 0.16 m = 8 pixels a step
 * to the right before nothing. Its right edge in frame 2 is at x = -0.5 + 0.32 + 0.5 = 0.32: pixel 80 + 16.
 */
static const char box[] = "kandil.scene { size = {160, 90}, fps = 10, gi = 'none' }\n"
                          "local box = kandil.spawn { mesh = { shape = 'box', size = {1, 1, 1} },\n"
                          "    transform = { position = {-0.5, 0, 0} },\n"
                          "    material = { unlit = true, base_color = {1, 0.5, 0.25, 1} } }\n"
                          "kandil.spawn { camera = { orthographic = true, y_mag = 0.9 },\n"
                          "               transform = { position = {0, 0, 5} } }\n"
                          "function kandil.update(t) box.transform.position = {-0.5 + 1.6 * t, 0, 0} end\n";
enum { EDGE = 96, STEP = 8 };

/* Eight moments while the shutter is open for a whole step: the box is seen at its place and 1 to 7 pixels
 * back. The pixel n + 1 left of the edge is covered in all moments but the 7 - n earliest. The curve of the
 * screen comes after the mean: half of white is the code of half the light, not half the code. */
static void a_moving_edge_is_a_ramp(void **state)
{
    (void)state;
    image_scenario("ramp.lua", "%s", box);
    image_render(image_path("ramp.lua"), "--frames", "3", "--subframes", "8", "--shutter", "360", "--out",
                 image_path("ramp.exr"), "--out", image_path("ramp.png"), "--set", "view.tonemap=linear");
    image p = image_read("ramp.exr"), screen = image_read("ramp.png");
    assert_double_near((double)*image_at(screen, EDGE - 4, 45), 0.7354, 0.003); /* sRGB code of 0.5 */
    image_free(&screen);
    for (int n = -2; n < STEP + 4; n++) {
        double share = n < 0 ? 0 : n >= STEP ? 1 : (n + 1) / (double)STEP;
        const float *texel = image_at(p, (uint32_t)(EDGE - 1 - n), 45);
        assert_double_near((double)texel[0], share, 1e-3);
        assert_double_near((double)texel[1], share * 0.5, 1e-3);
    }
    image_free(&p);
}

/* A shutter of 180 degrees is open for half of the step: the ramp is half as wide. */
static void the_shutter_says_how_wide_it_is(void **state)
{
    (void)state;
    image_scenario("half.lua", "%s", box);
    image_render(image_path("half.lua"), "--frames", "3", "--subframes", "4", "--out",
                 image_path("half.exr"));
    image p = image_read("half.exr");
    for (int n = 0; n < STEP; n++) {
        double share = n >= STEP / 2 ? 1 : (n + 1) / (STEP / 2.0);
        assert_double_near((double)*image_at(p, (uint32_t)(EDGE - 1 - n), 45), share, 1e-3);
    }
    image_free(&p);
}

static const char room[] =
    "kandil.scene { size = {48, 32}, fps = 10, gi = 'cones' }\n"
    "kandil.set('voxels.span', 0.05)\n"
    "kandil.spawn { mesh = { shape = 'box', size = {4, 0.1, 4} } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {0.6, 0.6, 0.6} },\n"
    "               transform = { position = {0, 0.5, 0}, rotation_deg = {20, 30, 0} },\n"
    "               material = { base_color = {0.8, 0.2, 0.1, 1} } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {-0.5, -1, "
    "-0.6} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1, 3}, look_at = {0, 0.4, 0} } "
    "}\n";

static void few_pixels_are_the_mean_of_many(void **state)
{
    (void)state;
    image_scenario("many.lua", "%s", room);
    image_render(image_path("many.lua"), "--frames", "1", "--size", "144x96", "--out",
                 image_path("many.exr"));
    image_render(image_path("many.lua"), "--frames", "1", "--supersample", "3", "--out",
                 image_path("few.exr"));
    image many = image_read("many.exr"), few = image_read("few.exr");
    assert_true(few.width == 48 && few.height == 32);
    for (uint32_t y = 0; y < few.height; y++)
        for (uint32_t x = 0; x < few.width; x++)
            for (int c = 0; c < 3; c++) {
                double mean = image_mean(many, c, x * 3, y * 3, x * 3 + 3, y * 3 + 3);
                assert_double_near((double)image_at(few, x, y)[c], mean, 1e-3 * mean + 1e-6);
            }
    image_free(&many);
    image_free(&few);
}

static void a_shutter_that_hardly_opens_shows_the_frame_itself(void **state)
{
    (void)state;
    image_scenario("still.lua", "%s", room);
    image_render(image_path("still.lua"), "--frames", "2", "--set", "light.bounces=0", "--out",
                 image_path("still.png"));
    image_render(image_path("still.lua"), "--frames", "2", "--set", "light.bounces=0", "--out",
                 image_path("again.png"), "--subframes", "4");
    image a = image_read("still.png"), b = image_read("again.png");
    assert_double_below(image_difference(a, b).max, 1.5 / 255); /* the mean of equal values is rounded */
    image_free(&a);
    image_free(&b);
}

/* Functions of the scenario are called once a step, with the same times and random numbers. */
static void the_scenario_does_not_notice(void **state)
{
    (void)state;
    char said[2][sizeof image_message];
    image_scenario("steps.lua", "%s%s", room,
                   "local n, sum, at = 0, 0, ''\n"
                   "kandil.every(0.15, function(t) at = at .. string.format(' %%.2f', t or 0) end)\n"
                   "function kandil.update(t, dt)\n"
                   "    n = n + 1; sum = sum + t * dt + math.random()\n"
                   "    kandil.log(n .. ' ' .. sum .. at)\n"
                   "end\n");
    for (int i = 0; i < 2; i++) {
        int code = i ? image_kandil("run", image_path("steps.lua"), "--frames", "5", "--subframes", "3",
                                    "--out", image_path("steps_%d.png"))
                     : image_kandil("run", image_path("steps.lua"), "--frames", "5", "--out",
                                    image_path("steps_%d.png"));
        assert_int_equal(code, 0);
        memcpy(said[i], image_message, sizeof image_message);
    }
    assert_string_equal(said[0], said[1]);
    assert_non_null(strstr(said[0], "5 "));
}

/* ---- 16 bits ---- */

static uint16_t *read_deep(const char *path, uint32_t *count)
{
    struct spng_ihdr header;
    void *data;
    size_t size, bytes;
    assert_int_equal(kd_file_read(path, KD_FILE_NO_LIMIT, &data, &size), KD_OK);
    spng_ctx *png = spng_ctx_new(0);
    assert_non_null(png);
    assert_int_equal(spng_set_png_buffer(png, data, size), 0);
    assert_int_equal(spng_get_ihdr(png, &header), 0);
    assert_int_equal(header.bit_depth, 16);
    assert_int_equal(header.color_type, SPNG_COLOR_TYPE_TRUECOLOR);
    assert_int_equal(spng_decoded_image_size(png, SPNG_FMT_PNG, &bytes), 0);
    uint16_t *words = malloc(bytes);
    assert_non_null(words);
    assert_int_equal(spng_decode_image(png, words, bytes, SPNG_FMT_PNG, 0), 0);
    spng_ctx_free(png);
    free(data);
    *count = header.width * header.height * 3;
    return words;
}

static void deep_pictures_are_the_others_with_more_bits(void **state)
{
    (void)state;
    uint32_t count, finer = 0;
    image_scenario("deep.lua", "%s", room);
    image_render(image_path("deep.lua"), "--frames", "1", "--out", image_path("flat.png"));
    image_render(image_path("deep.lua"), "--frames", "1", "--png-depth", "16", "--out",
                 image_path("deep.png"));
    uint16_t *words = read_deep(image_path("deep.png"), &count);
    image flat = image_read("flat.png");
    assert_int_equal(count, image_count(flat));
    for (uint32_t i = 0; i < count; i++) {
        assert_double_near(words[i] / 65535.0, (double)flat.rgb[i],
                           0.51 / 255 + 2e-4); /* light is rounded to halfs */
        finer += words[i] % 257 != 0;
    }
    assert_double_above(finer, 0.5 * count);
    free(words);
    image_free(&flat);
}

static void what_cannot_be_is_refused(void **state)
{
    (void)state;
    image_scenario("refused.lua", "%s", room);
    const char *path = image_path("refused.lua");
    assert_int_equal(image_kandil("run", path, "--frames", "1", "--supersample", "9"), 2);
    assert_int_equal(image_kandil("run", path, "--frames", "1", "--supersample", "8", "--size", "2049x16"),
                     2);
    assert_non_null(strstr(image_message, "16384"));
    assert_int_equal(image_kandil("run", path, "--frames", "1", "--png-depth", "12"), 2);
    assert_int_equal(image_kandil("run", path, "--frames", "1", "--subframes", "0"), 2);
    assert_int_equal(image_kandil("run", path, "--frames", "1", "--shutter", "361"), 2);
    assert_int_equal(image_kandil("run", path, "--frames", "1", "--layers", "--view", "octree"), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_moving_edge_is_a_ramp),
        cmocka_unit_test(the_shutter_says_how_wide_it_is),
        cmocka_unit_test(few_pixels_are_the_mean_of_many),
        cmocka_unit_test(a_shutter_that_hardly_opens_shows_the_frame_itself),
        cmocka_unit_test(the_scenario_does_not_notice),
        cmocka_unit_test(deep_pictures_are_the_others_with_more_bits),
        cmocka_unit_test(what_cannot_be_is_refused),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
