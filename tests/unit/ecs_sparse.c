/* Components kept beside the tables, and enable bits. Which rows queries show is compared with a model in
 * ecs_random.c; here are the promises a model does not see. */

#include "runtime/ecs/validate.h"
#include "tests/unit/ecs_fixture.h"

typedef struct spark {
    uint32_t heat;
} spark;
KD_COMPONENT_DEFINE_FLAGS(spark, "spark", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(spark, heat, KD_U32, "K", "how hot"));
typedef struct lamp {
    uint32_t power;
} lamp;
KD_COMPONENT_DEFINE_FLAGS(lamp, "lamp", KD_COMPONENT_TOGGLE, KD_FIELD(lamp, power, KD_U32, "W", "power"));
static const kd_component_desc held_desc = {.name = "held",
                                            .size = sizeof(owner),
                                            .align = _Alignof(owner),
                                            .on_remove = owner_release,
                                            .flags = KD_COMPONENT_SPARSE};

static void sparse_add_and_remove_move_no_row(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity a = kd_spawn(w, KD_VAL(position, {1, 2, 3}));
    const position *before = kd_find(w, a, position);
    assert_int_equal(kd_set(w, a, spark, {7}), KD_OK);
    assert_ptr_equal(kd_find(w, a, position), before);
    assert_int_equal(kd_find(w, a, spark)->heat, 7);
    kd_remove(w, a, spark);
    assert_ptr_equal(kd_find(w, a, position), before);
    assert_false(kd_has(w, a, spark));
    kd_world_destroy(w);
}

static void sparse_columns_are_arrays_of_the_rows_shown(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[8];
    for (uint32_t i = 0; i < 8; i++)
        e[i] = kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}));
    static const uint32_t order[] = {1, 2, 3, 6,
                                     5}; /* places 0 1 2 3 4: rows 1-3 follow each other, 5 and 6 do not */
    for (uint32_t i = 0; i < 5; i++)
        kd_set(w, e[order[i]], spark, {order[i]});
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position), KD_WRITE(spark)}});
    uint32_t runs = 0, rows = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); runs++) {
        const position *p = KD_COLUMN(&it, position, 0);
        spark *s = KD_COLUMN_MUT(&it, spark, 1);
        for (uint32_t i = 0; i < it.count; i++, rows++)
            assert_true((float)s[i].heat == p[i].x);
    }
    assert_int_equal(rows, 5);
    assert_int_equal(runs, 3);
    kd_world_destroy(w);
}

static void sparse_changes_are_seen(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity a = kd_spawn(w, KD_TAG(position), KD_VAL(spark, {1}));
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(spark)}});
    for (int round = 0; round < 4; round++) {
        kd_iter it = kd_query_iter(q);
        it.changed_since = kd_world_version(w);
        if (round & 1)
            kd_find_mut(w, a, spark)->heat++;
        assert_int_equal(kd_iter_next(&it), round & 1);
    }
    kd_world_destroy(w);
}

static void sparse_values_that_own_are_released_once(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[3];
    owner_releases = 0;
    for (int i = 0; i < 3; i++) {
        owner o = {owned(i)};
        e[i] = kd_spawn(w, KD_TAG(position), ((kd_value){&held_desc, &o}));
    }
    kd_destroy(w, e[0]);
    assert_int_equal(owner_releases, 1);
    kd_remove_id(w, e[2], kd_component_ensure(w, &held_desc));
    assert_int_equal(owner_releases, 2);
    owner o = {owned(9)};
    kd_set_value(w, e[1], (kd_value){&held_desc, &o}); /* releases the one before */
    assert_int_equal(owner_releases, 3);
    kd_world_destroy(w);
    assert_int_equal(owner_releases, 4);
}

static void values_given_may_lie_beside_the_tables(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity last = kd_spawn(w, KD_VAL(spark, {4711}));
    for (int i = 0; i < 3000; i++) { /* the array moves many times */
        const spark *s = kd_find(w, last, spark);
        last = i % 2 ? kd_spawn(w, ((kd_value){&spark_desc, s})) : kd_spawn(w, KD_TAG(position));
        if (i % 2 == 0)
            kd_set_value(w, last, (kd_value){&spark_desc, s});
        assert_int_equal(kd_find(w, last, spark)->heat, 4711);
    }
    spark many[100];
    kd_entity out[100];
    for (uint32_t i = 0; i < 100; i++)
        many[i].heat = i;
    const kd_component_desc *descs[] = {&position_desc, &spark_desc};
    const void *columns[] = {NULL, many};
    assert_int_equal(kd_spawn_n(w, 100, descs, columns, 2, out), KD_OK);
    for (uint32_t i = 0; i < 100; i++)
        assert_int_equal(kd_find(w, out[i], spark)->heat, i);
    kd_world_destroy(w);
}

static void disabled_components_hide_from_queries_alone(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity a = kd_spawn(w, KD_VAL(lamp, {40})), b = kd_spawn(w, KD_VAL(lamp, {60}));
    kd_query *with = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(lamp)}});
    kd_query *without = kd_query_make(w, &(kd_query_desc){.terms = {KD_WITHOUT(lamp)}});
    const lamp *place = kd_find(w, a, lamp);
    assert_true(kd_is_enabled(w, a, lamp));
    assert_int_equal(kd_disable(w, a, lamp), KD_OK);
    assert_false(kd_is_enabled(w, a, lamp));
    assert_true(kd_has(w, a, lamp));
    assert_ptr_equal(kd_find(w, a, lamp), place);
    assert_int_equal(kd_query_count(with), 1);
    assert_int_equal(kd_query_count(without), 1);
    kd_add(w, a, position); /* the row moves, the bit stays */
    assert_false(kd_is_enabled(w, a, lamp));
    kd_remove(w, a, lamp);
    kd_set(w, a, lamp, {5}); /* a new one starts enabled */
    assert_true(kd_is_enabled(w, a, lamp));
    kd_disable(w, b, lamp);
    kd_destroy(w, b);
    kd_entity next = kd_spawn(w, KD_TAG(lamp));
    assert_int_equal(next.index, b.index); /* the same index, and nothing left of the bit */
    assert_true(kd_is_enabled(w, next, lamp));
    kd_world_destroy(w);
}

static void bits_may_change_while_a_query_is_iterated(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[4];
    for (int i = 0; i < 4; i++)
        e[i] = kd_spawn(w, KD_TAG(lamp));
    kd_disable(w, e[1], lamp); /* two runs: row 0, rows 2-3 */
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(lamp)}});
    uint32_t rows = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count)
        kd_disable(w, e[3], lamp);
    assert_int_equal(rows, 2);
    kd_world_destroy(w);
}

static void enabling_what_was_not_declared_is_refused(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity a = kd_spawn(w, KD_TAG(position));
    kd_log_set_sink(silent, NULL);
    int errors = kd_log_count(KD_LOG_ERROR);
    assert_int_equal(kd_disable(w, a, position), KD_UNSUPPORTED);
    assert_int_equal(kd_log_count(KD_LOG_ERROR), errors + 1);
    assert_int_equal(kd_disable(w, a, lamp), KD_NOT_FOUND);
    assert_int_equal(kd_disable(w, KD_NO_ENTITY, lamp), KD_NOT_FOUND);
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(w);
}

static void a_component_given_twice_is_there_once(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    const spark first[3] = {{1}, {2}, {3}}, second[3] = {{4}, {5}, {6}};
    const position places[3] = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
                   others[3] = {{4, 0, 0}, {5, 0, 0}, {6, 0, 0}};
    kd_entity e[3];
    assert_int_equal(kd_spawn_n(w, 3,
                                (const kd_component_desc *const[]){&spark_desc, &position_desc, &spark_desc,
                                                                   &position_desc},
                                (const void *const[]){first, places, second, others}, 4, e),
                     KD_OK);
    assert_int_equal(kd_world_validate(w), KD_OK);
    assert_int_equal(kd_find(w, e[2], spark)->heat, 6);
    assert_true(kd_find(w, e[2], position)->x == 6);
    kd_remove(w, e[1], spark);
    assert_false(kd_has(w, e[1], spark));
    kd_entity one = kd_spawn(w, KD_VAL(spark, {7}), KD_VAL(position, {7, 0, 0}), KD_VAL(spark, {8}));
    assert_int_equal(kd_find(w, one, spark)->heat, 8);
    assert_int_equal(kd_world_validate(w), KD_OK);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sparse_add_and_remove_move_no_row),
        cmocka_unit_test(sparse_columns_are_arrays_of_the_rows_shown),
        cmocka_unit_test(sparse_changes_are_seen),
        cmocka_unit_test(sparse_values_that_own_are_released_once),
        cmocka_unit_test(values_given_may_lie_beside_the_tables),
        cmocka_unit_test(disabled_components_hide_from_queries_alone),
        cmocka_unit_test(bits_may_change_while_a_query_is_iterated),
        cmocka_unit_test(enabling_what_was_not_declared_is_refused),
        cmocka_unit_test(a_component_given_twice_is_there_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
