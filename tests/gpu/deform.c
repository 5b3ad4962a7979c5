/* The deform pass against its reference in C.
 *
 * Tolerances: positions are sums of sixteen products of numbers below 100, in another order or fused: 2e-5 of
 * the largest number in them. Directions are rounded to 16 bits, so that an error in the last float place may
 * turn one rounding; where the blended matrix is nearly singular that error grows, so that the vectors'
 * directions are compared there. */

#include "tests/stage_fixture.h"

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
    uint32_t *got = stage_read_all(s, store->geometry, (size_t)store->vertex_count * KD_GEOMETRY_WORDS * 4);
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
    void *got = stage_read_all(s, palette->matrices, palette->count * sizeof *palette->rows);
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
        stage_spawn(s, fixture_character(shapes[i][0], shapes[i][1], shapes[i][2], shapes[i][3], 100 + i));
    kd_entity mirrored = stage_spawn(s, fixture_character(1, 200, 6, 2, 77));
    kd_find_mut(s->world, mirrored, kd_transform)->scale = (kd_vec3){-1, 1, 2};
    for (int i = 0; i < 4; i++) {
        stage_frame(s);
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
    stage_frame(s);
    assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "b", &b),
                     KD_OK); /* the buffers grow */
    kd_find_mut(s->world, b, kd_transform)->position.x = 50;
    stage_frame(s);
    assert_equal_streams(s);
    const kd_draw_list *list = kd_singleton(s->world, kd_draw_list);
    assert_int_equal(list->draw_count, 2);
    assert_true(list->draws[1].bounds_min_ws.x - list->draws[0].bounds_min_ws.x > 49.9f);
}

static void a_frame_in_which_nothing_moves_costs_the_gpu_nothing(void **state)
{
    stage *s = *state;
    kd_entity root = stage_spawn(s, fixture_character(1, 100, 4, 2, 8));
    stage_frame(s);
    assert_non_null(strstr(s->ran, "scene_upload "));
    assert_non_null(strstr(s->ran, "draw_upload "));
    stage_frame(s);
    assert_string_equal(s->ran, "");
    kd_find_mut(s->world, root, kd_transform)->position.y = 1;
    stage_frame(s);
    assert_null(strstr(s->ran, "scene_upload "));
    assert_non_null(strstr(s->ran, "deform "));
    assert_equal_streams(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        STAGED(gpu_equals_reference),
        STAGED(instances_of_one_model_go_apart),
        STAGED(a_frame_in_which_nothing_moves_costs_the_gpu_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
