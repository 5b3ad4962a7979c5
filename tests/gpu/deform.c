/* The deform pass against its reference in C, and what scene_upload and draw_upload leave on the GPU.
 *
 * Tolerances: positions are sums of sixteen products of numbers below 100, in another order or fused: 2e-5 of
 * the largest number in them. Directions are rounded to 16 bits, so that an error in the last float place may
 * turn one rounding; where the blended matrix is nearly singular that error grows, so that the vectors'
 * directions are compared there. */

#include "tests/deform_fixture.h"

#include "runtime/gpu/gpu.h"
#include "systems/animation/animation.h"
#include "systems/deform/deform.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

typedef struct stage {
    kd_gpu *gpu;
    kd_world *world;
    kd_schedule *schedule;
    char ran[512]; /* names of the GPU systems of the last frame */
    char log[4096];
} stage;

static void keep_log(void *user, kd_log_level level, const char *text)
{
    stage *s = user;
    size_t used = strlen(s->log);
    if (level >= KD_LOG_WARNING)
        snprintf(s->log + used, sizeof s->log - used, "%s\n", text);
}

static void note_system(void *user, uint32_t system, uint32_t worker)
{
    stage *s = user;
    const kd_system_desc *desc = kd_schedule_system(s->schedule, system);
    size_t used = strlen(s->ran);
    (void)worker;
    if (desc->where == KD_ON_GPU)
        snprintf(s->ran + used, sizeof s->ran - used, "%s ", desc->name);
}

static void barrier(void *user, kd_gpu *gpu, uint32_t uses)
{
    (void)user;
    if (uses)
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE | KD_BARRIER_VERTEX);
}

static int setup(void **state)
{
    stage *s = calloc(1, sizeof *s);
    kd_log_set_sink(keep_log, s);
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &s->gpu) != KD_OK) {
        fprintf(stderr, "skipped: %s", s->log);
        exit(77);
    }
    s->world = kd_world_make();
    s->schedule = kd_schedule_make(s->world, NULL, s->gpu);
    kd_schedule_set_hooks(s->schedule,
                          &(kd_schedule_hooks){.begin = note_system, .barrier = barrier, .user = s});
    assert_int_equal(kd_animation_import(s->schedule), KD_OK);
    assert_int_equal(kd_hierarchy_import(s->schedule), KD_OK);
    assert_int_equal(kd_scene_import(s->schedule), KD_OK);
    assert_int_equal(kd_deform_import(s->schedule), KD_OK);
    if (kd_schedule_init(s->schedule) != KD_OK)
        fail_msg("init: %s", s->log);
    *state = s;
    return 0;
}

static int teardown(void **state)
{
    stage *s = *state;
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->world);
    bool clean = !kd_gpu_failed(s->gpu);
    kd_gpu_close(s->gpu);
    if (!clean)
        fprintf(stderr, "%s", s->log);
    kd_log_set_sink(NULL, NULL);
    free(s);
    return clean ? 0 : -1;
}

static void frame(stage *s)
{
    s->ran[0] = '\0';
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
    kd_gpu_barrier(s->gpu, KD_BARRIER_BUFFER_UPDATE);
}

static kd_entity spawn(stage *s, kd_model *model)
{
    uint32_t number;
    kd_entity root;
    assert_int_equal(kd_scene_add_model(s->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "thing", &root), KD_OK);
    return root;
}

static void *read_all(stage *s, kd_gpu_buffer buffer, size_t bytes)
{
    void *out = malloc(bytes ? bytes : 1);
    assert_non_null(out);
    if (bytes)
        kd_gpu_read_buffer(s->gpu, buffer, 0, out, bytes);
    return out;
}

/* ---- comparison ---- */

static kd_vec3 direction(const uint32_t *w)
{
    return (kd_vec3){(float)(int16_t)(w[0] & 0xffff) / 32767, (float)(int16_t)(w[0] >> 16) / 32767,
                     (float)(int16_t)(w[1] & 0xffff) / 32767};
}

/* Two roundings to 16 bits differ by one step an axis: 5.3e-5 in all; 1e-3 leaves room for nearly flat
 * matrices. */
static void assert_direction(const uint32_t *gpu, const uint32_t *reference, float tolerance, uint32_t *off)
{
    float d = kd_vec3_length(kd_vec3_sub(direction(gpu), direction(reference)));
    assert_true(d < 1e-3f);
    *off += d > tolerance;
}

static void assert_equal_streams(stage *s)
{
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    deform_picture expected = deform_by_reference(s->world);
    uint32_t *got = read_all(s, store->geometry, (size_t)store->vertex_count * KD_GEOMETRY_WORDS * 4);
    uint32_t off = 0;
    float largest = 1;
    for (uint32_t v = 0; v < store->vertex_count; v++)
        largest = fmaxf(largest, kd_vec3_length(deform_position(&expected, v)));
    for (uint32_t v = 0; v < store->vertex_count; v++) {
        const uint32_t *g = got + (size_t)v * KD_GEOMETRY_WORDS,
                       *e = expected.geometry + (size_t)v * KD_GEOMETRY_WORDS;
        kd_vec3 at;
        memcpy(&at, g, sizeof at);
        assert_true(kd_vec3_length(kd_vec3_sub(at, deform_position(&expected, v))) <= 2e-5f * largest);
        assert_direction(g + 3, e + 3, 8e-5f, &off);
        assert_direction(g + 5, e + 5, 8e-5f, &off);
        assert_int_equal(g[6] >> 16, e[6] >> 16); /* the tangent's side */
        assert_int_equal(g[7], 0);
    }
    assert_true(off <= store->vertex_count / 100); /* nearly singular blends are rare */
    free(got);
    deform_picture_free(&expected);
}

static void assert_palette(stage *s)
{
    const kd_joint_palette *palette = kd_singleton(s->world, kd_joint_palette);
    void *got = read_all(s, palette->matrices, palette->count * sizeof *palette->rows);
    if (palette->count)
        assert_memory_equal(got, palette->rows, palette->count * sizeof *palette->rows);
    free(got);
}

static void shake(stage *s, uint64_t *random)
{
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    for (uint32_t i = 0; i < store->joint_entity_count; i++) {
        kd_transform *t = kd_find_mut(s->world, store->joint_entities[i], kd_transform);
        t->rotation = fixture_quat(random);
        t->scale = fixture_vec3(random, 0.6f, 1.4f);
    }
    for (uint32_t i = 0; i < store->deformed_count; i++) {
        kd_morph_weights *w = kd_find_mut(s->world, store->deformed[i].entity, kd_morph_weights);
        for (uint32_t t = 0; w && t < w->count; t++)
            w->weights[t] = t % 2 ? 0 : fixture_float(random, -1, 1);
    }
}

/* ---- tests ---- */

static void gpu_equals_reference(void **state)
{
    stage *s = *state;
    uint64_t random = 21;
    static const uint32_t shapes[][4] = {/* parts, vertices, joints, morphs */
                                         {1, 1, 1, 0},    {1, 63, 2, 0},    {2, 64, 5, 1}, {1, 65, 0, 1},
                                         {3, 500, 40, 3}, {1, 900, 200, 0}, {2, 300, 0, 9}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        spawn(s, fixture_character(shapes[i][0], shapes[i][1], shapes[i][2], shapes[i][3], 100 + i));
    kd_entity mirrored = spawn(s, fixture_character(1, 200, 6, 2, 77));
    kd_find_mut(s->world, mirrored, kd_transform)->scale = (kd_vec3){-1, 1, 2};
    for (int i = 0; i < 4; i++) {
        frame(s);
        assert_non_null(strstr(s->ran, "deform "));
        assert_palette(s);
        assert_equal_streams(s);
        shake(s, &random);
    }
}

static void instances_of_one_model_go_apart(void **state)
{
    stage *s = *state;
    uint32_t number;
    kd_entity a, b;
    assert_int_equal(kd_scene_add_model(s->world, fixture_character(1, 100, 4, 0, 8), &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "a", &a), KD_OK);
    frame(s);
    assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "b", &b),
                     KD_OK); /* the buffers grow */
    kd_find_mut(s->world, b, kd_transform)->position.x = 50;
    frame(s);
    assert_equal_streams(s);
    const kd_draw_list *list = kd_singleton(s->world, kd_draw_list);
    assert_int_equal(list->draw_count, 2);
    assert_true(list->draws[1].bounds_min_ws.x - list->draws[0].bounds_min_ws.x > 49.9f);
}

static void a_frame_in_which_nothing_moves_costs_the_gpu_nothing(void **state)
{
    stage *s = *state;
    kd_entity root = spawn(s, fixture_character(1, 100, 4, 2, 8));
    frame(s);
    assert_non_null(strstr(s->ran, "scene_upload "));
    assert_non_null(strstr(s->ran, "draw_upload "));
    frame(s);
    assert_string_equal(s->ran, "");
    kd_find_mut(s->world, root, kd_transform)->position.y = 1;
    frame(s);
    assert_null(strstr(s->ran, "scene_upload "));
    assert_non_null(strstr(s->ran, "deform "));
    assert_equal_streams(s);
}

static void draw_list_arrives_as_it_is_on_the_cpu(void **state)
{
    stage *s = *state;
    kd_model *box = NULL;
    uint32_t number;
    kd_entity root;
    kd_material_desc material = kd_material_default();
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, 0, &material, &box), KD_OK);
    assert_int_equal(kd_scene_add_model(s->world, box, &number), KD_OK);
    for (int round = 0; round < 3; round++) { /* the second and third grow the buffers */
        for (int i = 0; i < 30; i++) {
            assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "box", &root), KD_OK);
            *kd_find_mut(s->world, root, kd_transform) =
                (kd_transform){{(float)i, 0, 0}, {0, 0, 0, 1}, {1, 2, i % 2 ? 4.0f : -4.0f}};
        }
        frame(s);
        const kd_draw_list *list = kd_singleton(s->world, kd_draw_list);
        assert_int_equal(list->draw_count, 30 * (round + 1));
        assert_int_equal(list->batch_count, 2);
        struct kd_object *objects = read_all(s, list->objects, list->object_count * sizeof *objects);
        kd_draw_indexed *args = read_all(s, list->args, list->draw_count * sizeof *args);
        uint32_t *ids = read_all(s, list->object_ids, list->object_count * sizeof *ids);
        for (uint32_t i = 0; i < list->draw_count; i++) {
            kd_entity e = list->draws[i].entity;
            assert_int_equal(ids[i], i);
            assert_int_equal(objects[i].info.z, e.index);
            assert_int_equal(objects[i].info.y, (i >= list->batches[1].first_draw ? KD_OBJECT_MIRRORED : 0));
            assert_memory_equal(objects[i].model_ws.m, kd_find(s->world, e, kd_world_transform)->matrix.m,
                                64);
            assert_float_equal(objects[i].normal_ws[1].y, 0.5f, 1e-6f); /* inverse of the scale 2 along y */
            assert_memory_equal(&args[i], &list->draws[i].args, sizeof args[i]);
        }
        free(objects);
        free(args);
        free(ids);
    }
}

static void textures_are_made_once_for_each_way_of_reading(void **state)
{
    stage *s = *state;
    static const uint8_t pixels[2 * 2 * 4] = {255, 0, 0,   255, 0,   255, 0,   255,
                                              0,   0, 255, 255, 255, 255, 255, 255};
    uint64_t random = 2;
    kd_model *model = fixture_model();
    kd_image *image = FIXTURE_NEW(model, kd_image, 1);
    *image = (kd_image){"image", 2, 2, pixels};
    kd_material_desc *materials = FIXTURE_NEW(model, kd_material_desc, 2);
    for (int i = 0; i < 2; i++) {
        materials[i] = kd_material_default();
        materials[i].base_color_map.image = 0;
        materials[i].metallic_roughness_map.image = 0;
    }
    kd_primitive_desc *primitive = FIXTURE_NEW(model, kd_primitive_desc, 1);
    *primitive = fixture_primitive(model, 9, 0, 0, &random);
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    *mesh = (kd_mesh_desc){.name = "mesh", .primitive_count = 1, .primitives = primitive};
    fixture_nodes(model, 1)->mesh = 0;
    model->meshes = mesh;
    model->mesh_count = 1;
    model->materials = materials;
    model->material_count = 2;
    model->images = image;
    model->image_count = 1;
    spawn(s, model);
    frame(s);
    const kd_store_material *stored = kd_singleton(s->world, kd_scene_store)->materials + 1;
    assert_true(stored[0].maps[0].id != 0 && stored[0].maps[1].id != 0);
    assert_int_not_equal(stored[0].maps[0].id, stored[0].maps[1].id); /* sRGB and linear */
    assert_int_equal(stored[0].maps[0].id, stored[1].maps[0].id);
    assert_int_equal(stored[0].maps[1].id, stored[1].maps[1].id);
    assert_int_equal(stored[0].maps[2].id, 0);
}

#define STAGED(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        STAGED(gpu_equals_reference),
        STAGED(instances_of_one_model_go_apart),
        STAGED(a_frame_in_which_nothing_moves_costs_the_gpu_nothing),
        STAGED(draw_list_arrives_as_it_is_on_the_cpu),
        STAGED(textures_are_made_once_for_each_way_of_reading),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
