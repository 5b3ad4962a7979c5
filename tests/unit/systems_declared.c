/* The CPU systems of a frame touch what they declare, and no order that their declarations allow changes what
 * comes out: tried over an animated scene. */

#include "tests/deform_fixture.h"

#include "runtime/ecs/system.h"
#include "systems/animation/animation.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

enum { FRAMES = 8, MODELS = 12 };

static void add_swing(kd_model *model)
{
    static const float times[] = {0, 1}, values[] = {0, 0, 0, 1, 0, 0.7071068f, 0, 0.7071068f};
    static const kd_channel_desc channel = {1, KD_PATH_ROTATION, KD_INTERPOLATE_LINEAR, 2, 4, times, values};
    static const kd_clip_desc clip = {"swing", 1, 1, &channel, 0, NULL};
    model->clips = &clip;
    model->clip_count = 1;
}

typedef struct outcome {
    uint64_t checksum;
    uint32_t draws, palette_rows;
    double rows; /* of the palette, added up */
} outcome;

static void add_systems(kd_schedule *s)
{
    assert_int_equal(kd_animation_import(s), KD_OK);
    assert_int_equal(kd_hierarchy_import(s), KD_OK);
    assert_int_equal(deform_register_joint_palette(s), KD_OK);
    assert_int_equal(scene_register_draw_list(s), KD_OK);
    assert_int_equal(scene_register_camera(s), KD_OK);
}

static void add_scene(kd_world *w)
{
    kd_model *model = fixture_character(2, 100, 6, 2, 4);
    uint32_t number;
    kd_entity root;
    add_swing(model);
    assert_int_equal(kd_scene_add_model(w, model, &number), KD_OK);
    for (int i = 0; i < MODELS; i++)
        assert_int_equal(kd_scene_instantiate(w, number, KD_NO_ENTITY, "one of many", &root), KD_OK);
    kd_scene_store *store = kd_singleton(w, kd_scene_store);
    scene_internal *in = store->internal;
    store->uploaded_primitives = store->primitive_count; /* as if a GPU had taken them */
    in->uploaded_deformed = store->deformed_count;
}

static outcome run(uint32_t threads, uint64_t seed, bool checked)
{
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(threads);
    kd_schedule *s = kd_schedule_make(w, jobs, NULL);
    add_systems(s);
    add_scene(w);
    assert_int_equal(kd_schedule_check(s, checked), KD_OK);
    kd_schedule_randomize(s, seed);
    for (int frame = 0; frame < FRAMES; frame++)
        assert_int_equal(kd_schedule_run(s), KD_OK);
    for (uint32_t i = 0; i < kd_schedule_count(s); i++)
        assert_int_equal(kd_schedule_statistics(s, i).runs, FRAMES);
    const kd_joint_palette *palette = kd_singleton(w, kd_joint_palette);
    outcome o = {.checksum = kd_world_checksum(w),
                 .draws = kd_singleton(w, kd_draw_list)->draw_count,
                 .palette_rows = palette->count};
    for (uint32_t i = 0; i < palette->count * 12; i++)
        o.rows += ((const float *)(const void *)palette->rows)[i];
    kd_schedule_destroy(s);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
    return o;
}

static void assert_same(outcome a, outcome b)
{
    assert_true(a.checksum == b.checksum && a.rows == b.rows);
    assert_int_equal(a.draws, b.draws);
    assert_int_equal(a.palette_rows, b.palette_rows);
}

static void systems_touch_what_they_declare(void **state)
{
    (void)state;
    outcome free = run(2, 0, false);
    assert_int_equal(free.draws, 2 * MODELS);
    assert_true(free.palette_rows >= MODELS);
    assert_same(run(1, 0, true), free);
    assert_same(run(2, 3, true), free);
}

static void legal_orders_and_threads_change_nothing(void **state)
{
    (void)state;
    outcome expected = run(1, 0, false);
    for (uint32_t threads = 1; threads <= 4; threads++)
        assert_same(run(threads, 0, false), expected);
    for (uint64_t seed = 1; seed <= 16; seed++)
        assert_same(run(2, seed, false), expected);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(systems_touch_what_they_declare),
        cmocka_unit_test(legal_orders_and_threads_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
