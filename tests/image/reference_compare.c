/* The path tracer and the comparison as commands: what they write, that the reference shows the same scene as
 * the renderer, and how they refuse. */

#include "tests/image_fixture.h"

static const char room[] =
    "kandil.scene { size = {96, 64}, fps = 10, seconds = 1 }\n"
    "local box = kandil.spawn { name = 'box', mesh = { shape = 'box', size = 1 }, material = { base_color = "
    "{0.8, 0.4, 0.2} } }\n"
    "kandil.spawn { mesh = { shape = 'plane', size = {9, 1, 9} }, transform = { position = {0, -0.5, 0} } }\n"
    "kandil.spawn { light = { type = 'point', intensity = 20 }, transform = { position = {1, 2, 2} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {2, 1.5, 3}, look_at = {0, 0, 0} } "
    "}\n"
    "function kandil.update(t) box.transform.rotation_deg = {0, 70 * t, 0} end\n";

/* A path that stays, unlike image_path's. */
static const char *write_scene(const char *name, const char *text)
{
    static char path[256];
    snprintf(path, sizeof path, "%s", image_scenario(name, "%s", text));
    return path;
}

static void expect_code(int code, int wanted)
{
    if (code != wanted)
        fail_msg("exit code %d: %s", code, image_message);
}

static void expect_message(const char *part)
{
    if (!strstr(image_message, part))
        fail_msg("'%s' does not say '%s'", image_message, part);
}

/* Share of texels that differ by more than `tolerance`. */
static double share_that_differs(image a, image b, float tolerance)
{
    size_t count = 0, pixels = (size_t)a.width * a.height;
    assert_true(a.width == b.width && a.height == b.height);
    for (size_t i = 0; i < pixels; i++) {
        bool differs = false;
        for (size_t k = 0; k < 3; k++)
            differs |= fabsf(a.rgb[i * 3 + k] - b.rgb[i * 3 + k]) > tolerance;
        count += differs;
    }
    return (double)count / (double)pixels;
}

/* What both renderers must agree on to the last edge: where surfaces are, how they are turned, what they are
 * made of, and direct light but for the penumbras of shadow maps. */
static void expect_same_scene(const char *scene, const char *frames, double edges)
{
    static const struct {
        const char *view;
        float tolerance;
    } views[] = {{"depth", 0.01f}, {"normal", 0.01f}, {"albedo", 0.02f}, {"direct", 0.05f}};
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        image_render(scene, "--frames", frames, "--gi", "none", "--view", views[i].view, "--out",
                     image_path("gl.exr"));
        expect_code(image_kandil("reference", scene, "--frames", frames, "--spp", "1", "--bounces", "0",
                                 "--pixel", "centre", "--terms", views[i].view, "--out",
                                 image_path("ref.exr"), "--quiet"),
                    0);
        image a = image_read("gl.exr"), b = image_read("ref.exr");
        double share = share_that_differs(a, b, views[i].tolerance);
        if (share > edges * (i == 3 ? 4 : 1))
            fail_msg("%s: view %s differs in %.4f of the pixels", scene, views[i].view, share);
        image_free(&a);
        image_free(&b);
    }
}

static void reference_shows_the_renderers_scene_at_any_frame(void **state)
{
    (void)state;
    const char *scene = write_scene("room.lua", room);
    expect_same_scene(scene, "1", 0.005);
    expect_same_scene(scene, "8", 0.005);
}

/* A skinned walker: posed by our own arithmetic here, by the deform pass there. */
static void reference_poses_characters_as_the_renderer_does(void **state)
{
    (void)state;
    const char *scene =
        write_scene("walk.lua", "kandil.scene { size = {96, 96}, fps = 10, seconds = 2 }\n"
                                "kandil.spawn { model = 'walker.gltf', animation = {} }\n"
                                "kandil.spawn { light = { type = 'directional', intensity = 2 }, "
                                "transform = { look_at = {-0.4, -1, -0.5} } }\n"
                                "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = "
                                "{1.5, 1.2, 2.5}, look_at = {0, 0.8, 0} } }\n");
    image_render(scene, "--asset-root", KD_SOURCE_DIR "/samples/assets", "--frames", "8", "--gi", "none",
                 "--view", "normal", "--out", image_path("gl.exr"));
    expect_code(image_kandil("reference", scene, "--asset-root", KD_SOURCE_DIR "/samples/assets", "--frame",
                             "7", "--spp", "1", "--bounces", "0", "--pixel", "centre", "--terms", "normal",
                             "--out", image_path("ref.exr"), "--quiet"),
                0);
    image a = image_read("gl.exr"), b = image_read("ref.exr");
    double share = share_that_differs(a, b, 0.02f);
    assert_false(image_is_constant(b));
    if (share > 0.01)
        fail_msg("%.4f of the pixels differ", share);
    image_free(&a);
    image_free(&b);
}

static void reference_writes_every_term_asked_for(void **state)
{
    (void)state;
    const char *scene = write_scene("room.lua", room);
    expect_code(image_kandil("reference", scene, "--size", "16x12", "--spp", "4", "--terms",
                             "final,direct,indirect,diffuse,specular,ao,albedo,normal,depth", "--out",
                             image_path("all.exr"), "--out", image_path("all.png"), "--stats",
                             image_path("s.json"), "--quiet"),
                0);
    image final = image_read("all.exr"), direct = image_read("all_direct.exr"),
          indirect = image_read("all_indirect.exr");
    for (size_t i = 0; i < image_count(final); i++) /* halfs are rounded by 2^-11 of their size */
        assert_double_near((double) final.rgb[i], (double)direct.rgb[i] + (double)indirect.rgb[i],
                           0.002 * (double) final.rgb[i] + 1e-5);
    image_free(&final);
    image_free(&direct);
    image_free(&indirect);
    static const char *const names[] = {"all.png",          "all_ao.png",    "all_albedo.png",
                                        "all_normal.png",   "all_depth.png", "all_diffuse.exr",
                                        "all_specular.exr", "s.json"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        assert_true(kd_file_exists(image_path(names[i])));
}

static void reference_is_the_same_every_time(void **state)
{
    (void)state;
    const char *scene = write_scene("room.lua", room);
    expect_code(image_kandil("reference", scene, "--size", "32x24", "--spp", "8", "--threads", "1", "--out",
                             image_path("one.exr"), "--quiet"),
                0);
    expect_code(image_kandil("reference", scene, "--size", "32x24", "--spp", "8", "--threads", "3", "--out",
                             image_path("three.exr"), "--quiet"),
                0);
    assert_same_file("one.exr", "three.exr");
}

static void compare_measures_pictures_and_techniques(void **state)
{
    (void)state;
    const char *scene = write_scene("room.lua", room);
    expect_code(image_kandil("compare", scene, "--size", "48x32", "--spp", "8", "--frame", "3", "--report",
                             image_path("report"), "--quiet"),
                0);
    static const char *const names[] = {"report/report.html", "report/report.json",
                                        "report/reference_final.exr", "report/cones_final.exr",
                                        "report/none_indirect.exr"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        assert_true(kd_file_exists(image_path(names[i])));
    expect_code(image_kandil("compare", image_path("report/reference_final.exr"),
                             image_path("report/reference_final.exr"), "--json", image_path("same.json")),
                0);
    void *json;
    size_t size;
    assert_int_equal(kd_file_read(image_path("report/report.json"), KD_FILE_NO_LIMIT, &json, &size), KD_OK);
    assert_non_null(strstr(json, "all gathers")); /* endless bounces, as the setting is by default */
    free(json);
    assert_int_equal(kd_file_read(image_path("same.json"), KD_FILE_NO_LIMIT, &json, &size), KD_OK);
    assert_non_null(strstr(json, "\"flip_ldr\": 0,"));
    assert_non_null(strstr(json, "\"flip_hdr\": 0,"));
    assert_non_null(strstr(json, "\"relmse\": 0,"));
    assert_non_null(strstr(json, "\"ssim\": 1,"));
    free(json);
}

static void commands_refuse_what_they_cannot_do(void **state)
{
    (void)state;
    const char *scene = write_scene("room.lua", room);
    expect_code(image_kandil("reference", scene), 2);
    expect_message("add --out");
    expect_code(image_kandil("reference", scene, "--out", image_path("x.mp4")), 2);
    expect_code(image_kandil("reference", scene, "--out", image_path("x.exr"), "--terms", "final,shadow"), 2);
    expect_message("shadow");
    expect_code(image_kandil("reference", scene, "--out", image_path("x.exr"), "--bounces", "-1"), 2);
    expect_code(image_kandil("reference", scene, "--out", image_path("x.exr"), "--spp", "0"), 2);
    expect_code(image_kandil("reference", image_path("none.lua"), "--out", image_path("x.exr")), 1);
    expect_code(image_kandil("reference", scene, "--out", image_path("no/folder/x.exr")), 1);
    expect_code(image_kandil("compare", image_path("a.exr")), 2);
    expect_message("second picture");
    expect_code(
        image_kandil("compare", image_path("a.exr"), image_path("b.exr"), "--report", image_path("r")), 2);
    expect_message("--html");
    expect_code(image_kandil("compare", image_path("a.exr"), image_path("b.exr")), 1);
    expect_message("a.exr");
    expect_code(image_kandil("reference", scene, "--size", "8x8", "--spp", "1", "--out", image_path("a.exr"),
                             "--quiet"),
                0);
    expect_code(image_kandil("reference", scene, "--size", "8x9", "--spp", "1", "--out", image_path("b.png"),
                             "--quiet"),
                0);
    expect_code(image_kandil("compare", image_path("a.exr"), image_path("b.png")), 1);
    expect_message("8x9");
    assert_int_equal(kd_file_write(image_path("c.exr"), "not a picture", 13), KD_OK);
    expect_code(image_kandil("compare", image_path("a.exr"), image_path("c.exr")), 1);
    expect_message("c.exr");
    expect_code(
        image_kandil("compare", image_path("a.exr"), image_path("a.exr"), "--set", "box.light.intensity=1"),
        2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_shows_the_renderers_scene_at_any_frame),
        cmocka_unit_test(reference_poses_characters_as_the_renderer_does),
        cmocka_unit_test(reference_writes_every_term_asked_for),
        cmocka_unit_test(reference_is_the_same_every_time),
        cmocka_unit_test(compare_measures_pictures_and_techniques),
        cmocka_unit_test(commands_refuse_what_they_cannot_do),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
