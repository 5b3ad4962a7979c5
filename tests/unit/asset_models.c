/* Real models load, and are what their makers say they are. */

#include <math.h>

#include "tests/unit/asset_support.h"

#define ASSETS KD_SOURCE_DIR "/../shared/assets/"

static kd_model *load(const char *name)
{
    char path[512];
    kd_model *model = NULL;
    snprintf(path, sizeof path, "%s%s", ASSETS, name);
    watch_messages();
    assert_int_equal(kd_model_load(path, &model), KD_OK);
    assert_int_equal(seen_messages.errors, 0);
    return model;
}

/* Triangles of the meshes themselves; triangle_count is over instances. */
static uint64_t mesh_triangles(const kd_model *m)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < m->mesh_count; i++)
        for (uint32_t p = 0; p < m->meshes[i].primitive_count; p++)
            count += m->meshes[i].primitives[p].index_count / 3;
    return count;
}

static bool is_unit(const float *v, int n)
{
    float sum = 0;
    for (int i = 0; i < n; i++)
        sum += v[i] * v[i];
    return fabsf(sum - 1) < 1e-4f; /* normalised in float: a few units in the last place */
}

static void check_primitive(const kd_primitive_desc *p)
{
    assert_int_equal(p->index_count % 3, 0);
    for (uint32_t i = 0; i < p->index_count; i++)
        assert_true(p->indices[i] < p->vertex_count);
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        assert_true(is_unit(&p->normals[i].x, 3));
        assert_true(is_unit(&p->tangents[i].x, 3));
        assert_true(p->tangents[i].w == 1 || p->tangents[i].w == -1);
        assert_true(p->positions[i].x >= p->bounds_min.x && p->positions[i].x <= p->bounds_max.x);
        if (p->weights)
            NEAR(p->weights[i].x + p->weights[i].y + p->weights[i].z + p->weights[i].w, 1, 1e-5f);
    }
}

/* What model.h promises of every model. */
static void check_promises(const kd_model *m)
{
    for (uint32_t i = 0; i < m->mesh_count; i++)
        for (uint32_t p = 0; p < m->meshes[i].primitive_count; p++)
            check_primitive(&m->meshes[i].primitives[p]);
    for (uint32_t i = 0; i < m->node_count; i++) {
        const kd_node_desc *n = &m->nodes[i];
        assert_non_null(n->name);
        assert_true(n->parent == KD_NONE || n->parent < i);
        assert_true(n->mesh == KD_NONE || n->mesh < m->mesh_count);
        assert_true(is_unit(&n->rotation.x, 4));
    }
    for (uint32_t i = 0; i < m->skin_count; i++)
        for (uint32_t j = 0; j < m->skins[i].joint_count; j++)
            assert_true(m->skins[i].joints[j] < m->node_count);
    for (uint32_t c = 0; c < m->clip_count; c++)
        for (uint32_t i = 0; i < m->clips[c].channel_count; i++) {
            const kd_channel_desc *channel = &m->clips[c].channels[i];
            assert_true(channel->node < m->node_count);
            for (uint32_t k = 1; k < channel->key_count; k++)
                assert_true(channel->times[k] > channel->times[k - 1]);
            assert_true(channel->times[channel->key_count - 1] <= m->clips[c].duration);
        }
}

static void every_model_loads_with_its_known_counts(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint32_t triangles, skins, joints, clips, images;
    } known[] = {
        {"sponza/sponza.glb", 262267, 0, 0, 0, 24},
        {"cornell_box/cornell_box.glb", 32, 0, 0, 0, 0},
        {"robot/robot.glb", 3238, 1, 43, 14, 0},
        {"cesium_man/CesiumMan.glb", 4672, 1, 19, 1, 1},
        {"simple_skin/SimpleSkin.gltf", 8, 1, 2, 1, 0},
        {"cesium_milk_truck/CesiumMilkTruck.glb", 2856, 0, 0, 1, 1},
        {"animated_morph_cube/AnimatedMorphCube.gltf", 12, 0, 0, 1, 0},
        {"sparse_morph_cube/singleBlendshapeCube_sparse.glb", 12, 0, 0, 1, 0},
        {"bunny/bunny.glb", 3674, 0, 0, 0, 0},
        {"dragon/dragon.glb", 47794, 0, 0, 0, 0},
        {"teapot/teapot.glb", 992, 0, 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        kd_model *m = load(known[i].name);
        assert_int_equal(mesh_triangles(m), known[i].triangles);
        assert_int_equal(m->skin_count, known[i].skins);
        assert_int_equal(m->skin_count ? m->skins[0].joint_count : 0, known[i].joints);
        assert_int_equal(m->clip_count, known[i].clips);
        assert_int_equal(m->image_count, known[i].images);
        check_promises(m);
        kd_model_destroy(m);
    }
}

static void truck_counts_a_wheel_axle_twice(void **state)
{
    (void)state;
    kd_model *m = load("cesium_milk_truck/CesiumMilkTruck.glb");
    /* One wheel mesh of 768 triangles stands under two nodes: 2856 + 768. */
    assert_int_equal(m->triangle_count, 2856 + 768);
    kd_model_destroy(m);
}

static void cornell_box_has_its_camera_lamp_and_size(void **state)
{
    (void)state;
    kd_model *m = load("cornell_box/cornell_box.glb");
    assert_int_equal(m->camera_count, 1);
    NEAR(m->cameras[0].fov_y, 39.3f * 3.14159265f / 180, 1e-3f); /* stated with three digits */
    float brightest = 0;
    for (uint32_t i = 0; i < m->material_count; i++)
        brightest = fmaxf(brightest, m->materials[i].emissive.x);
    NEAR(brightest, 17, 1e-4f); /* emissive factor 1 times the strength 17 */
    /* The box as published: 556 by 548.8 by 559.2 mm. */
    assert_vec3(m->bounds_max, 0.556f, 0.5488f, 0.5592f, 1e-3f);
    kd_model_destroy(m);
}

static void morph_cubes_have_their_targets(void **state)
{
    (void)state;
    kd_model *m = load("animated_morph_cube/AnimatedMorphCube.gltf");
    assert_int_equal(m->meshes[0].morph_count, 2);
    assert_int_equal(m->clips[0].channels[0].path, KD_PATH_WEIGHTS);
    assert_int_equal(m->clips[0].channels[0].width, 2);
    kd_model_destroy(m);
    m = load("sparse_morph_cube/singleBlendshapeCube_sparse.glb");
    const kd_primitive_desc *p = &m->meshes[0].primitives[0];
    assert_int_equal(m->meshes[0].morph_count, 1);
    uint32_t moved = 0;
    for (uint32_t i = 0; i < p->vertex_count; i++)
        moved += kd_vec3_length(p->morph_positions[0][i]) > 0;
    assert_true(moved > 0 && moved < p->vertex_count); /* sparse: some vertices move, not all */
    kd_model_destroy(m);
}

static void walking_man_stands_upright_in_rest_pose(void **state)
{
    (void)state;
    kd_model *m = load("cesium_man/CesiumMan.glb");
    /* The mesh is modelled with +Z up and turned by its joints: about 1.5 m tall along +Y only if the skin is
     * applied. */
    NEAR(m->bounds_max.y - m->bounds_min.y, 1.5f, 0.05f);
    assert_int_equal(m->images[0].width, 1024);
    assert_int_equal(m->images[0].height, 1024);
    kd_model_destroy(m);
}

static void sponza_masks_and_tiles(void **state)
{
    (void)state;
    kd_model *m = load("sponza/sponza.glb");
    uint32_t masked = 0;
    for (uint32_t i = 0; i < m->material_count; i++)
        masked += m->materials[i].alpha_mode == KD_ALPHA_MASK && m->materials[i].alpha_cutoff == 0.5f;
    assert_int_equal(masked, 3); /* leaf, chain, vase_plant */
    for (uint32_t i = 0; i < m->image_count; i++)
        assert_true(m->images[i].width <= 512 && m->images[i].height <= 512);
    kd_model_destroy(m);
}

/* What a clone without its large files leaves in their place. */
static void a_pointer_to_a_file_elsewhere_is_named(void **state)
{
    (void)state;
    load_bad("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 12345\n", NULL, 0,
             KD_BAD_FORMAT, "pointer of Git LFS; fetch its content with `git lfs pull`");
}

/* A scenario's models read nothing outside of its folders, by whatever way they name it. */
static void files_outside_the_roots_are_refused(void **state)
{
    static const char *const names[] = {"../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "%2Fetc/passwd",
                                        "data.bin"};
    char roots[1][KD_PATH_MAX], json[1024];
    (void)state;
    assert_int_equal(kd_path_folder(roots[0], KD_PATH_MAX, in_folder("case.gltf")), KD_OK);
    for (size_t i = 0; i < 4; i++) {
        kd_model *model = NULL;
        snprintf(
            json, sizeof json,
            "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{"
            "'POSITION':0}}]}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"
            "'bufferViews':[{'buffer':0,'byteLength':36}],'buffers':[{'uri':'%s','byteLength':36}]}",
            names[i]);
        (void)load_case(json, NULL, 0, &model); /* writes the file; what comes of it without roots is known */
        kd_model_destroy(model);
        unlink(in_folder("data.bin"));
        assert_int_equal(symlink("/etc/passwd", in_folder("data.bin")), 0);
        watch_messages();
        kd_model_options options = {.roots = (const char(*)[KD_PATH_MAX])roots, .root_count = 1};
        assert_int_not_equal(kd_model_load_with(in_folder("case.gltf"), &options, &model), KD_OK);
        assert_int_equal(seen_messages.errors, 1);
        assert_non_null(strstr(seen_messages.last_error,
                               i == 2 ? "no usable file name" : "outside the scenario's folder"));
        unlink(in_folder("data.bin"));
    }
}

int main(void)
{
    if (access(ASSETS "sponza/sponza.glb", R_OK) != 0) {
        printf("skipped: there is no folder of real models at %s\n", ASSETS);
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_outside_the_roots_are_refused),
        cmocka_unit_test(a_pointer_to_a_file_elsewhere_is_named),
        cmocka_unit_test(every_model_loads_with_its_known_counts),
        cmocka_unit_test(truck_counts_a_wheel_axle_twice),
        cmocka_unit_test(cornell_box_has_its_camera_lamp_and_size),
        cmocka_unit_test(morph_cubes_have_their_targets),
        cmocka_unit_test(walking_man_stands_upright_in_rest_pose),
        cmocka_unit_test(sponza_masks_and_tiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
