/* Which caches are made in a frame: what is needed now, and ahead as much as keeps all dates at an even rate.
 */

#include "systems/voxel_cache/columns.h"
#include "systems/voxel_cache/plan.h"
#include "tests/systems_fixture.h"

enum { CACHES = 60 };

/* Caches with work of their own, due in given numbers of frames. */
static void set_caches(kd_voxel_scene *scene, kd_voxel_cache *caches, const uint32_t *due, const float *work)
{
    for (uint32_t i = 0; i < CACHES; i++)
        caches[i] = (kd_voxel_cache){.alive = true, .due = due[i], .work = work[i]};
    *scene = (kd_voxel_scene){.caches = caches, .cache_count = CACHES, .unmade = CACHES};
}

/* Make what is chosen and let a frame pass; gives the work done. */
static float pass_frame(voxel_plan *plan, kd_voxel_scene *scene)
{
    float done = 0;
    assert_int_equal(plan_choose(plan, scene), KD_OK);
    for (uint32_t i = 0; i < plan->count; i++) {
        kd_voxel_cache *c = &scene->caches[plan->items[i].cache];
        assert_false(c->made);
        c->made = true;
        scene->unmade--;
        done += c->work;
    }
    for (uint32_t i = 0; i < scene->cache_count; i++) {
        kd_voxel_cache *c = &scene->caches[i];
        assert_true(c->made || c->due > 0);
        c->due -= c->due > 0;
    }
    return done;
}

static void all_is_made_in_time(void **state)
{
    (void)state;
    uint64_t random = 7;
    voxel_plan plan = {0};
    for (int round = 0; round < 200; round++) {
        kd_voxel_cache caches[CACHES];
        kd_voxel_scene scene;
        uint32_t due[CACHES];
        float work[CACHES];
        for (int i = 0; i < CACHES; i++) {
            due[i] = fixture_random(&random) % 24;
            work[i] = fixture_float(&random, 1, 100);
        }
        set_caches(&scene, caches, due, work);
        for (int frame = 0; scene.unmade; frame++) {
            assert_true(frame <= 24);
            pass_frame(&plan, &scene);
            for (int i = 0; i < CACHES; i++) /* what is needed in the next frame is there before */
                assert_true(caches[i].made || caches[i].due > 0);
        }
    }
    plan_fini(&plan);
}

/* 20 a frame are due in frames 1 to 3 and none later: a third of all in each frame, within one of them. Had
 * all been due in frame 3 the rate were the same. */
static void work_is_spread_evenly(void **state)
{
    (void)state;
    voxel_plan plan = {0};
    for (int late = 0; late < 2; late++) {
        kd_voxel_cache caches[CACHES];
        kd_voxel_scene scene;
        uint32_t due[CACHES];
        float work[CACHES];
        for (uint32_t i = 0; i < CACHES; i++) {
            due[i] = late ? 3 : 1 + i / 20;
            work[i] = 5;
        }
        set_caches(&scene, caches, due, work);
        for (int frame = 0; frame < 3; frame++)
            assert_float_equal(pass_frame(&plan, &scene), 100, 5.01);
        assert_int_equal(scene.unmade, 0);
    }
    plan_fini(&plan);
}

static void what_is_needed_now_is_made_whatever_it_costs(void **state)
{
    (void)state;
    voxel_plan plan = {0};
    kd_voxel_cache caches[CACHES];
    kd_voxel_scene scene;
    uint32_t due[CACHES] = {0};
    float work[CACHES];
    for (uint32_t i = 0; i < CACHES; i++) {
        due[i] = i < 10 ? 0 : 20;
        work[i] = i < 10 ? 1000 : 1;
    }
    set_caches(&scene, caches, due, work);
    assert_float_equal(pass_frame(&plan, &scene), 10000,
                       0.5); /* and nothing else: it was enough for one frame */
    plan_fini(&plan);
}

/* What is estimated is what the voxelizer lists, but for cells that a triangle crosses less than a whole one
 * of: between equal and the margin of one more in each direction. */
static void estimate_is_near_what_is_listed(void **state)
{
    (void)state;
    const kd_shape shapes[] = {KD_SHAPE_BOX, KD_SHAPE_SPHERE, KD_SHAPE_TORUS, KD_SHAPE_PLANE};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        kd_model *model;
        kd_material_desc grey = kd_material_default();
        assert_int_equal(kd_model_make_shape(shapes[i], (kd_vec3){1, 0.5f, 0.8f}, 0, &grey, &model), KD_OK);
        const kd_primitive_desc *p = &model->meshes[0].primitives[0];
        const float span = 0.02f;
        kd_voxel_chunk chunk = {.origin = {-2, -2, -2}, .span = span, .size = {200, 200, 200}};
        kd_columns columns = {0};
        assert_int_equal(columns_list(p, &chunk, false, &columns), KD_OK);
        float estimate = columns_estimate(p, &(kd_voxel_cache){.span = span});
        assert_in_range((uint32_t)estimate, columns.columns * 3 / 4, columns.columns * 4 / 3);
        free(columns.rows);
        kd_model_destroy(model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_is_made_in_time),
        cmocka_unit_test(work_is_spread_evenly),
        cmocka_unit_test(what_is_needed_now_is_made_whatever_it_costs),
        cmocka_unit_test(estimate_is_near_what_is_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
