/* World transforms against a naive recursive computation. */

#include "tests/systems_fixture.h"

#include "systems/hierarchy/hierarchy.h"

typedef struct tree {
    kd_world *world;
    kd_schedule *schedule;
} tree;

static int setup(void **state)
{
    static tree t;
    t.world = kd_world_make();
    t.schedule = kd_schedule_make(t.world, NULL, NULL);
    assert_int_equal(kd_hierarchy_import(t.schedule), KD_OK);
    assert_int_equal(kd_schedule_init(t.schedule), KD_OK);
    *state = &t;
    return 0;
}

static int teardown(void **state)
{
    tree *t = *state;
    kd_schedule_destroy(t->schedule);
    kd_world_destroy(t->world);
    return 0;
}

static kd_mat4 naive(const kd_world *w, kd_entity e)
{
    const kd_transform *pose = kd_find(w, e, kd_transform);
    const kd_local_matrix *matrix = kd_find(w, e, kd_local_matrix);
    kd_mat4 local = matrix ? matrix->matrix
                    : pose ? kd_mat4_from_trs(pose->position, pose->rotation, pose->scale)
                           : KD_MAT4_IDENTITY;
    kd_entity parent = kd_get_parent(w, e);
    if (!parent.generation)
        return local;
    kd_mat4 above = naive(w, parent);
    return kd_mat4_mul(&above, &local);
}

static kd_transform random_pose(uint64_t *random)
{
    kd_transform t = {fixture_vec3(random, -3, 3), fixture_quat(random), fixture_vec3(random, 0.8f, 1.2f)};
    return t;
}

/* The system multiplies in the same order as the recursion, so the results are equal, not just close. */
static void assert_placed(const kd_world *w, const kd_entity *entities, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        kd_mat4 expected = naive(w, entities[i]);
        assert_memory_equal(&kd_find(w, entities[i], kd_world_transform)->matrix, &expected, sizeof expected);
    }
}

enum { N = 300 };

static void grow(kd_world *w, kd_entity *entities, uint64_t *random)
{
    for (uint32_t i = 0; i < N; i++) {
        kd_transform pose = random_pose(random);
        uint32_t kind = fixture_random(random) % 8;
        kd_local_matrix shear = {{{1, 0, 0, 0, 0.5f, 1, 0, 0, 0, 0, 1, 0, pose.position.x, 0, 0, 1}}};
        const kd_value posed[] = {{&kd_transform_desc, &pose}, {&kd_world_transform_desc, NULL}};
        const kd_value sheared[] = {{&kd_local_matrix_desc, &shear}, {&kd_world_transform_desc, NULL}};
        entities[i] = kd_spawn_values(w, kind == 0 ? sheared : posed, 2);
        if (i && kind != 1)
            assert_int_equal(kd_set_parent(w, entities[i], entities[fixture_random(random) % i]), KD_OK);
    }
}

static void random_trees_equal_the_recursion(void **state)
{
    tree *t = *state;
    kd_entity entities[N];
    for (uint64_t seed = 1; seed <= 5; seed++) {
        uint64_t random = seed;
        grow(t->world, entities, &random);
        assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
        assert_placed(t->world, entities, N);
        for (uint32_t i = 0; i < 20; i++) { /* move some, hang some elsewhere */
            kd_entity e = entities[fixture_random(&random) % N];
            kd_transform *pose = kd_find_mut(t->world, e, kd_transform);
            if (pose)
                *pose = random_pose(&random);
            (void)kd_set_parent(t->world, e, entities[0]);
        }
        assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
        assert_placed(t->world, entities, N);
    }
}

static uint32_t changed_rows(kd_query *q, uint64_t since)
{
    kd_iter it = kd_query_iter(q);
    uint32_t rows = 0;
    it.changed_since = since;
    while (kd_iter_next(&it))
        rows += it.count;
    return rows;
}

static void what_rests_is_not_marked_changed(void **state)
{
    tree *t = *state;
    kd_entity entities[N];
    uint64_t random = 9;
    grow(t->world, entities, &random);
    kd_query *q = kd_query_make(t->world, &(kd_query_desc){.terms = {KD_READ(kd_world_transform)}});
    assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
    uint64_t version = kd_world_version(t->world);
    assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
    assert_int_equal(changed_rows(q, version), 0);
    kd_transform *pose = NULL;
    for (uint32_t i = N; i-- > 0 && !pose;) /* the last one made has no children, so it alone moves */
        pose = kd_find_mut(t->world, entities[i], kd_transform);
    pose->position.x += 1;
    assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
    assert_in_range(changed_rows(q, version), 1, N - 1);
    kd_query_destroy(q);
}

static void a_pose_without_world_transform_gets_one(void **state)
{
    tree *t = *state;
    kd_entity top = kd_spawn(t->world, KD_VAL(kd_transform, {{1, 0, 0}, {0, 0, 0, 1}, {2, 2, 2}}));
    kd_entity child = kd_spawn(t->world, KD_VAL(kd_transform, {{0, 3, 0}, {0, 0, 0, 1}, {1, 1, 1}}));
    assert_int_equal(kd_set_parent(t->world, child, top), KD_OK);
    assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
    const kd_world_transform *world = kd_find(t->world, child, kd_world_transform);
    assert_non_null(world); /* 1 + 2*0, 0 + 2*3, 0 */
    assert_float_equal(world->matrix.m[12], 1, 0);
    assert_float_equal(world->matrix.m[13], 6, 0);
    assert_float_equal(world->matrix.m[0], 2, 0);
}

static void a_root_without_pose_stays_where_it_was_put(void **state)
{
    tree *t = *state;
    kd_mat4 at = KD_MAT4_IDENTITY;
    at.m[12] = 5;
    kd_entity root = kd_spawn(t->world, KD_VAL(kd_world_transform, {at}));
    assert_int_equal(kd_schedule_run(t->schedule), KD_OK);
    assert_float_equal(kd_find(t->world, root, kd_world_transform)->matrix.m[12], 5, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(random_trees_equal_the_recursion, setup, teardown),
        cmocka_unit_test_setup_teardown(what_rests_is_not_marked_changed, setup, teardown),
        cmocka_unit_test_setup_teardown(a_pose_without_world_transform_gets_one, setup, teardown),
        cmocka_unit_test_setup_teardown(a_root_without_pose_stays_where_it_was_put, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
