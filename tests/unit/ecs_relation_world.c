/* Relations in everything that looks at a world as a whole: snapshots, differences, JSON, statistics, memory.
 */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/statistics.h"
#include "tests/relation_fixture.h"

static void snapshots_carry_pairs_in_both_orders(void **state)
{
    (void)state;
    kd_entity e[60];
    kd_world *w = related_world(e, 60), *other = kd_world_make();
    kd_snapshot s = {0}, again = {0};
    register_relations(other);
    assert_int_equal(kd_snapshot_write(w, &s), KD_OK);
    assert_int_equal(kd_snapshot_restore(other, s.data, s.size), KD_OK);
    assert_int_equal(kd_world_validate(other), KD_OK);
    assert_true(kd_world_checksum(w) == kd_world_checksum(other));
    assert_int_equal(kd_world_diff(w, other, NULL, 0), 0);
    assert_int_equal(kd_snapshot_write(other, &again), KD_OK);
    assert_true(s.size == again.size && memcmp(s.data, again.data, s.size) == 0);
    for (int k = 0; k < 2; k++) { /* both go on alike */
        kd_world *one = k ? other : w;
        kd_destroy(one, e[3]);
        kd_relate_with(one, e[5], likes, e[7], {1, e[1]});
        kd_remove(one, e[9], likes);
        kd_destroy(one, kd_clone(one, e[11]));
    }
    assert_true(kd_world_checksum(w) == kd_world_checksum(other));
    assert_int_equal(kd_snapshot_restore(w, s.data, s.size), KD_OK); /* over pairs that are there */
    assert_int_equal(kd_world_validate(w), KD_OK);
    kd_relate_with(w, e[0], holds, e[1], {owned(1)});
    kd_log_set_sink(silent, NULL);
    assert_int_equal(kd_snapshot_write(w, &again), KD_UNSUPPORTED);
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(kd_snapshot_restore(w, s.data, s.size), KD_OK); /* releases what was owned */
    kd_snapshot_fini(&s);
    kd_snapshot_fini(&again);
    kd_world_destroy(w);
    kd_world_destroy(other);
}

static void differences_of_pairs_are_named(void **state)
{
    (void)state;
    kd_entity e[4];
    kd_world *a = kd_world_make(), *b = kd_world_make();
    kd_difference d[4];
    char text[128];
    spawn_all(a, e, 4);
    spawn_all(b, e, 4);
    kd_relate_with(a, e[0], likes, e[1], {1, e[1]});
    kd_relate_with(b, e[0], likes, e[1], {2, e[1]});
    assert_int_equal(kd_world_diff(a, b, d, 4), 1);
    assert_string_equal(kd_difference_text(a, b, d, text, sizeof text),
                        "entity 0.1: likes to 1.1.much differs");
    kd_relate_with(b, e[0], likes, e[1], {1, e[1]});
    kd_relate(b, e[0], likes, e[2]);
    assert_int_equal(kd_world_diff(a, b, d, 4), 1);
    assert_string_equal(kd_difference_text(a, b, d, text, sizeof text),
                        "entity 0.1: likes to 2.1 only in the second world");
    assert_int_equal(kd_world_diff(b, a, d, 4), 1);
    assert_true(d[0].kind == KD_DIFFERENCE_PAIR && d[0].in == 0);
    kd_unrelate(a, e[0], likes, e[1]);
    kd_relate(a, e[0], likes, e[2]);
    kd_relate_with(a, e[0], likes, e[1], {1, e[1]});
    assert_int_equal(kd_world_diff(a, b, d, 4), 1);
    assert_string_equal(kd_difference_text(a, b, d, text, sizeof text),
                        "entity 0.1: pairs of likes come in another order");
    assert_true(kd_world_checksum(a) != kd_world_checksum(b));
    kd_remove(a, e[0], likes);
    kd_remove(b, e[0], likes);
    kd_relate(a, e[0], knows, e[3]);
    kd_relate(a, e[1], knows, e[3]);
    kd_relate(b, e[1], knows, e[3]);
    kd_relate(b, e[0], knows, e[3]);
    assert_int_equal(kd_world_diff(a, b, d, 4), 1); /* the order of sources */
    assert_true(d[0].kind == KD_DIFFERENCE_PAIR_ORDER && d[0].entity.index == e[3].index);
    assert_true(kd_world_checksum(a) != kd_world_checksum(b));
    kd_world_destroy(a);
    kd_world_destroy(b);
}

static void json_and_statistics_show_pairs(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[2];
    kd_component_statistics s;
    spawn_all(w, e, 2);
    kd_relate(w, e[0], knows, e[1]);
    kd_relate_with(w, e[0], aims_at, e[1], {0.5f});
    kd_relate_with(w, e[1], aims_at, e[1], {2});
    kd_json j = {0};
    kd_world_write_json(w, &j);
    const char *text = kd_json_text(&j);
    assert_non_null(strstr(text, "\"relations\""));
    assert_non_null(strstr(text, "\"since\""));
    assert_null(strstr(text, "\"likes\""));
    kd_json_fini(&j);
    assert_int_equal(kd_component_count_memory(w, KD_ID(w, aims_at), &s), KD_OK);
    assert_true(s.entities == 2 && s.pairs == 2 && s.used_bytes == 8 && s.held_bytes >= 2 * 24);
    kd_world_write_statistics(w, &j);
    assert_non_null(strstr(kd_json_text(&j), "\"pairs\""));
    kd_json_fini(&j);
    kd_world_destroy(w);
}

/* 100 000 pairs of an exclusive relation without values, two sources a target. */
static void a_pair_takes_few_bytes_and_gives_them_back(void **state)
{
    (void)state;
    enum { N = 100000 };
    static kd_entity e[N];
    kd_world *w = kd_world_make();
    spawn_all(w, e, N);
    size_t before = kd_world_bytes(w);
    for (uint32_t i = 0; i < N; i++)
        kd_relate(w, e[i], part_of, e[i / 2]);
    /* 8 + 4 + 12 at the source, 8 + 12 / 2 at the target, 8 for the cascade; pools grow by quarters */
    assert_true((kd_world_bytes(w) - before) / N < 64);
    for (uint32_t i = 0; i < N; i++)
        kd_remove(w, e[i], part_of);
    assert_true(kd_world_bytes(w) - before < 2 * N * sizeof(kd_entity));
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(snapshots_carry_pairs_in_both_orders),
        cmocka_unit_test(differences_of_pairs_are_named),
        cmocka_unit_test(json_and_statistics_show_pairs),
        cmocka_unit_test(a_pair_takes_few_bytes_and_gives_them_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
