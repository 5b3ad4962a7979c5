/* Queries by relation: any target or one, in the order of relating or by depth, columns as arrays, changes.
 */

#include "tests/relation_fixture.h"

/* Entities in the order in which a query shows them, as their places in `e`. */
static uint32_t visit(kd_iter it, const kd_entity *e, uint32_t n, uint32_t *order)
{
    uint32_t count = 0;
    while (kd_iter_next(&it))
        for (uint32_t i = 0; i < it.count; i++)
            for (uint32_t k = 0; k < n; k++)
                if (kd_entity_equal(it.entities[i], e[k]))
                    order[count++] = k;
    return count;
}

static void assert_order(kd_query *q, kd_entity target, const kd_entity *e, uint32_t n, const char *expected)
{
    uint32_t order[32];
    char text[33] = {0};
    uint32_t count = visit(kd_query_iter_to(q, target), e, n, order);
    for (uint32_t i = 0; i < count; i++)
        text[i] = (char)('0' + order[i]);
    assert_string_equal(text, expected);
}

static void queries_ask_for_any_target_or_for_one(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[8];
    spawn_all(w, e, 8);
    kd_set(w, e[5], velocity, {1, 0, 0}); /* another table */
    kd_relate(w, e[4], knows, e[0]);
    kd_relate(w, e[5], knows, e[0]);
    kd_relate(w, e[2], knows, e[0]);
    kd_relate(w, e[3], knows, e[0]);
    kd_relate(w, e[3], knows, e[1]);
    kd_relate(w, e[6], likes, e[0]);
    kd_query_desc any = {.terms = {KD_READ(position), KD_WITH(knows)}}, none = {.terms = {KD_WITHOUT(knows)}},
                  one = {.terms = {KD_READ(position), KD_PAIR(knows, e[0])}},
                  still = {.terms = {KD_PAIR(knows, e[0]), KD_WITHOUT(velocity)}},
                  not = {.terms = {KD_WITH(knows), KD_WITHOUT_PAIR(knows, e[1])}},
                  two = {.terms = {KD_PAIR(knows, e[0]), KD_PAIR(knows, e[1])}};
    kd_query *q_any = kd_query_make(w, &any), *q_one = kd_query_make(w, &one);
    assert_order(q_any, KD_NO_ENTITY, e, 8, "2345");                   /* tables and rows */
    assert_order(kd_query_make(w, &none), KD_NO_ENTITY, e, 8, "0176"); /* 7 came into the gap of 5 */
    assert_order(q_one, KD_NO_ENTITY, e, 8, "4523");                   /* in order of relating */
    assert_order(q_any, e[0], e, 8, "4523");                           /* the same question, asked later */
    assert_order(q_any, e[1], e, 8, "3");
    assert_order(q_any, e[7], e, 8, "");
    assert_order(kd_query_make(w, &still), KD_NO_ENTITY, e, 8, "423");
    assert_order(kd_query_make(w, &not ), KD_NO_ENTITY, e, 8, "245");
    assert_order(kd_query_make(w, &two), KD_NO_ENTITY, e, 8, "3");
    assert_int_equal(kd_query_count(q_one), 4);
    assert_ptr_equal(kd_query_make(w, &one), q_one);
    assert_ptr_not_equal(kd_query_make(w, &two), kd_query_make(w, &still));
    kd_iter it = kd_query_iter(q_one); /* 2 and 3 lie one behind the other: one chunk */
    uint32_t chunks = 0;
    while (kd_iter_next(&it)) {
        assert_non_null(KD_COLUMN(&it, position, 0));
        chunks++;
    }
    assert_int_equal(chunks, 3);
    kd_destroy(w, e[0]);
    assert_int_equal(kd_query_count(q_one), 0);
    kd_entity again = kd_spawn(w, KD_TAG(position)); /* its index in use again */
    kd_relate(w, e[6], knows, again);
    assert_int_equal(kd_query_count(q_one), 0);
    kd_log_set_sink(silent, NULL);
    assert_null(kd_query_make(w, &(kd_query_desc){.terms = {KD_PAIR(position, e[1])}}));
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(w);
}

static void queries_by_depth_show_parents_first(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[5];
    spawn_all(w, e, 2);
    e[2] = kd_spawn_child(w, e[1], KD_TAG(position));
    e[3] = kd_spawn_child(w, e[2], KD_TAG(velocity));
    e[4] = kd_spawn_child(w, e[1], KD_TAG(velocity));
    for (int i = 4; i >= 0; i--)
        kd_relate(w, e[i], knows, e[0]);
    kd_query_desc desc = {.terms = {KD_PAIR(knows, e[0])}, .by_depth = true};
    assert_order(kd_query_make(w, &desc), KD_NO_ENTITY, e, 5, "10423");
    kd_world_destroy(w);
}

static void columns_of_pairs_are_arrays(void **state)
{
    (void)state;
    enum { N = 600 };
    static kd_entity e[N];
    kd_world *w = kd_world_make();
    spawn_all(w, e, N);
    for (uint32_t i = 0; i < N; i++)
        kd_relate_with(w, e[i], aims_at, e[i / 2], {(float)i});
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(aims_at), KD_WRITE(position)}});
    uint32_t rows = 0, chunks = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count, chunks++) {
        const aims_at *a = KD_COLUMN(&it, aims_at, 0);
        const kd_entity *targets = kd_iter_targets(&it, 0);
        position *p = KD_COLUMN_MUT(&it, position, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            assert_float_equal(a[i].since, (float)(rows + i), 0);
            assert_entity(targets[i], e[(rows + i) / 2]);
            p[i].y = a[i].since;
        }
    }
    assert_true(rows == N && chunks == 1); /* related in the order of rows: one run */
    q = kd_query_make(
        w, &(kd_query_desc){.terms = {KD_WRITE_PAIR(aims_at, e[100]), KD_OPTIONAL_PAIR(likes, e[0])}});
    kd_relate_with(w, e[201], likes, e[0], {5, KD_NO_ENTITY});
    rows = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count) {
        assert_int_equal(it.count, 1); /* 201 has what 200 has not */
        assert_entity(it.entities[0], e[200 + rows]);
        KD_COLUMN_MUT(&it, aims_at, 0)->since = 1;
        const likes *l = KD_COLUMN(&it, likes, 1);
        assert_true(rows ? l && l->much == 5 : !l);
        assert_entity(*kd_iter_targets(&it, 0), e[100]);
    }
    assert_int_equal(rows, 2);
    assert_float_equal(kd_find(w, e[200], aims_at)->since, 1, 0);
    kd_world_destroy(w);
}

static uint32_t changed_rows(kd_query *q, uint64_t since)
{
    uint32_t rows = 0;
    kd_iter it = kd_query_iter(q);
    it.changed_since = since;
    while (kd_iter_next(&it))
        rows += it.count;
    return rows;
}

static void changes_of_pairs_are_seen(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    static kd_entity e[1000];
    spawn_all(w, e, 1000);
    for (uint32_t i = 0; i < 1000; i++)
        kd_relate(w, e[i], aims_at, e[0]);
    kd_query *places =
        kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position), KD_PAIR(aims_at, e[0])}});
    kd_query *values = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ_PAIR(aims_at, e[0])}});
    uint64_t since = kd_world_version(w);
    assert_int_equal(changed_rows(places, since) + changed_rows(values, since), 0);
    kd_find_mut(w, e[600], position)->x = 1; /* the third chunk of 256 */
    assert_int_equal(changed_rows(places, since), 256);
    assert_int_equal(changed_rows(values, since), 0);
    since = kd_world_version(w);
    kd_pair_find_mut(w, e[3], aims_at, e[0])->since = 1;
    assert_int_equal(changed_rows(places, since), 0);
    assert_int_equal(changed_rows(values, since), 1000);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queries_ask_for_any_target_or_for_one),
        cmocka_unit_test(queries_by_depth_show_parents_first),
        cmocka_unit_test(columns_of_pairs_are_arrays),
        cmocka_unit_test(changes_of_pairs_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
