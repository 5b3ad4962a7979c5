/* Animated models that others made: what moves in the file moves in the picture, in the voxels and in the
 * shadow. Skipped where the models are not at hand. */

#include "tests/image_fixture.h"

#define ASSETS KD_SOURCE_DIR "/../shared/assets"

#define NEED(path)                                                                                           \
    if (!kd_file_exists(ASSETS "/" path))                                                                    \
    skip()

static void render_frames(const char *model, const char *name)
{
    char pattern[64];
    snprintf(pattern, sizeof pattern, "%s%%d.png", name);
    image_render(model, "--frames", "4", "--fps", "4", "--size", "96x54", "--out", image_path(pattern));
}

/* Each frame differs from the one before in at least some pixels. */
static void assert_moving(const char *name)
{
    for (int i = 0; i < 3; i++) {
        char names[2][64];
        snprintf(names[0], sizeof names[0], "%s%d.png", name, i);
        snprintf(names[1], sizeof names[1], "%s%d.png", name, i + 1);
        image a = image_read(names[0]), b = image_read(names[1]);
        assert_false(image_is_constant(a));
        if (image_difference(a, b).max < 0.05)
            fail_msg("%s and %s show the same", names[0], names[1]);
        image_free(&a);
        image_free(&b);
    }
}

static void a_skinned_man_walks(void **state)
{
    (void)state;
    NEED("cesium_man/CesiumMan.glb");
    render_frames(ASSETS "/cesium_man/CesiumMan.glb", "man");
    assert_moving("man");
}

static void wheels_turn(void **state)
{
    (void)state;
    NEED("cesium_milk_truck/CesiumMilkTruck.glb");
    render_frames(ASSETS "/cesium_milk_truck/CesiumMilkTruck.glb", "truck");
    assert_moving("truck");
}

static void a_morphing_cube_changes_shape(void **state)
{
    (void)state;
    NEED("animated_morph_cube/AnimatedMorphCube.gltf");
    render_frames(ASSETS "/animated_morph_cube/AnimatedMorphCube.gltf", "cube");
    assert_moving("cube");
}

/* The file's clip has one key, which says weight 0. In a copy it says 1: half of the cube's corners then lie
 * farther along x, by one and a half edges. */
static void a_sparse_morph_target_is_added(void **state)
{
    enum { HEADERS = 28, WEIGHT_OFFSET = 4 }; /* of a .glb with two chunks; of the key in the second one */
    static const float one = 1;
    void *data;
    uint32_t json_bytes;
    size_t size;
    (void)state;
    NEED("sparse_morph_cube/singleBlendshapeCube_sparse.glb");
    assert_int_equal(kd_file_read(ASSETS "/sparse_morph_cube/singleBlendshapeCube_sparse.glb",
                                  KD_FILE_NO_LIMIT, &data, &size),
                     KD_OK);
    assert_int_equal(kd_file_write(image_path("still.glb"), data, size), KD_OK);
    memcpy(&json_bytes, (char *)data + 12, 4);
    memcpy((char *)data + HEADERS + json_bytes + WEIGHT_OFFSET, &one, 4);
    assert_int_equal(kd_file_write(image_path("moved.glb"), data, size), KD_OK);
    free(data);
    for (int i = 0; i < 2; i++) {
        static const char *const names[2] = {"still", "moved"};
        char scene[64], png[64];
        snprintf(scene, sizeof scene, "%s.lua", names[i]);
        snprintf(png, sizeof png, "%s.png", names[i]);
        image_render(
            image_scenario(
                scene,
                "kandil.scene { size = {96, 54} }\n"
                "kandil.spawn { model = '%s.glb', animation = {}, transform = { scale = {100, 100, 100} } }\n"
                "kandil.spawn { light = {}, transform = { look_at = {-1, -2, -3} } }\n"
                "kandil.spawn { camera = {}, transform = { position = {0, 0, 6} } }\n",
                names[i]),
            "--frames", "1", "--view", "albedo", "--out", image_path(png));
    }
    image still = image_read("still.png"), moved = image_read("moved.png");
    /* At 6 m and 45 degrees a pixel is 0.09 m: the cube's right half ends 6 pixels right of the middle, the
     * target 16 farther. */
    assert_double_below((double)*image_at(still, 60, 27), 0.01);
    assert_double_above((double)*image_at(moved, 60, 27), 0.1);
    image_free(&still);
    image_free(&moved);
}

/* ---- a dancer in the Cornell box ---- */

/* Three frames. */
static void render_dancer(const char *view, const char *pattern)
{
    const char *scene = image_scenario(
        "dance.lua", "%s",
        "kandil.scene { size = {96, 54}, fps = 4 }\n"
        "kandil.spawn { model = 'samples/assets/cornell.gltf' }\n"
        "kandil.spawn { model = 'robot/robot.glb', animation = { clip = 'Robot_Dance', loop = true },\n"
        "               transform = { scale = {0.25, 0.25, 0.25} } }\n"
        "kandil.spawn { light = { type = 'spot', intensity = 16, outer_cone_deg = 70 },\n"
        "               transform = { position = {0.3, 1.9, 0.4}, look_at = {0, 0, 0} } }\n"
        "kandil.spawn { camera = { fov_y_deg = 40 },\n"
        "               transform = { position = {0, 1, 3.5}, look_at = {0, 0.95, 0} } }\n");
    image_render(scene, "--frames", "3", "--view", view, "--asset-root", ASSETS, "--asset-root",
                 KD_SOURCE_DIR, "--out", image_path(pattern));
}

static void a_dancers_voxels_and_light_move(void **state)
{
    static const char *const views[] = {"final", "direct", "indirect", "ao", "octree"};
    (void)state;
    NEED("robot/robot.glb");
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        render_dancer(views[i], "dance%d.png");
        image a = image_read("dance0.png"), b = image_read("dance2.png");
        if (image_difference(a, b).mean < 1e-3)
            fail_msg("view %s does not move", views[i]);
        image_free(&a);
        image_free(&b);
    }
}

/* The floor beside the dancer: its albedo stays, its light does not. That is the shadow and the bounce. */
static void a_dancers_shadow_moves_over_the_floor(void **state)
{
    static const char *const views[] = {"direct", "indirect"};
    (void)state;
    NEED("robot/robot.glb");
    render_dancer("albedo", "albedo%d.png");
    image before = image_read("albedo0.png"), after = image_read("albedo2.png");
    for (int v = 0; v < 2; v++) {
        render_dancer(views[v], "dance%d.exr");
        image a = image_read("dance0.exr"), b = image_read("dance2.exr");
        uint32_t floor = 0, changed = 0;
        for (uint32_t y = 44; y < 54; y++)
            for (uint32_t x = 0; x < 96; x++) {
                const float *p = image_at(before, x, y), *q = image_at(after, x, y);
                if (p[0] != q[0] || p[1] != q[1] || p[2] != q[2] || fabsf(p[0] - p[2]) > 0.1f || p[0] < 0.1f)
                    continue;
                float one = *image_at(a, x, y), other = *image_at(b, x, y);
                floor++;
                changed += fabsf(one - other) > 0.1f * fmaxf(one, other);
            }
        assert_true(floor > 200);
        if (changed < floor / 25)
            fail_msg("view %s: %u of %u pixels of the floor changed", views[v], changed, floor);
        image_free(&a);
        image_free(&b);
    }
    image_free(&before);
    image_free(&after);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_skinned_man_walks),
        cmocka_unit_test(wheels_turn),
        cmocka_unit_test(a_morphing_cube_changes_shape),
        cmocka_unit_test(a_sparse_morph_target_is_added),
        cmocka_unit_test(a_dancers_voxels_and_light_move),
        cmocka_unit_test(a_dancers_shadow_moves_over_the_floor),
    };
    if (!kd_file_exists(ASSETS "/ASSETS.md"))
        return 77;
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
