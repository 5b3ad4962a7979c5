/* Relations: pairs are found from both ends, keep their order, go with either end, and are copied, recorded
 * and observed like components. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "tests/relation_fixture.h"

static void a_pair_is_found_from_both_ends(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[3];
    spawn_all(w, e, 3);
    assert_false(kd_related(w, e[0], likes, e[1]));
    assert_int_equal(kd_relate_with(w, e[0], likes, e[1], {0.5f, KD_NO_ENTITY}), KD_OK);
    assert_int_equal(kd_relate(w, e[0], likes, e[2]), KD_OK);
    assert_int_equal(kd_relate(w, e[2], likes, e[1]), KD_OK);
    assert_true(kd_related(w, e[0], likes, e[1]) && !kd_related(w, e[1], likes, e[0]));
    assert_float_equal(kd_pair_find(w, e[0], likes, e[1])->much, 0.5f, 0);
    kd_pair_find_mut(w, e[0], likes, e[2])->much = 2;
    kd_entities to = kd_targets(w, e[0], likes), from = kd_sources(w, e[1], likes);
    assert_true(to.count == 2 && from.count == 2);
    assert_entity(to.at[0], e[1]);
    assert_entity(to.at[1], e[2]);
    assert_float_equal(kd_target_values(w, e[0], likes)[1].much, 2, 0);
    assert_entity(from.at[0], e[0]);
    assert_entity(from.at[1], e[2]);
    assert_entity(kd_target(w, e[0], likes), e[1]);
    assert_int_equal(kd_pair_count(w, likes), 3);
    kd_unrelate(w, e[0], likes, e[1]);
    kd_unrelate(w, e[0], likes, e[1]); /* twice does nothing */
    assert_entity(kd_target(w, e[0], likes), e[2]);
    assert_int_equal(kd_sources(w, e[1], likes).count, 1);
    assert_int_equal(kd_targets(w, e[1], likes).count, 0);
    assert_int_equal(kd_target(w, e[1], likes).generation, 0);
    kd_world_destroy(w);
}

static void misuse_is_refused_with_words(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[2];
    spawn_all(w, e, 2);
    kd_entity dead = kd_spawn(w, KD_TAG(position));
    kd_destroy(w, dead);
    assert_int_equal(kd_relate(w, e[0], knows, dead), KD_NOT_FOUND);
    assert_int_equal(kd_relate(w, dead, knows, e[0]), KD_NOT_FOUND);
    assert_int_equal(kd_relate(w, e[0], knows, KD_NO_ENTITY), KD_NOT_FOUND);
    assert_false(kd_related(w, e[0], knows, dead));
    kd_log_set_sink(silent, NULL);
    assert_int_equal(kd_relate(w, e[0], position, e[1]), KD_UNSUPPORTED);
    assert_int_equal(kd_set(w, e[0], likes, {1, KD_NO_ENTITY}), KD_UNSUPPORTED);
    assert_int_equal(kd_spawn(w, KD_TAG(knows)).generation, 0);
    assert_int_equal(kd_spawn_n(w, 3, (const kd_component_desc *const[]){&knows_desc}, NULL, 1, NULL),
                     KD_UNSUPPORTED);
    assert_int_equal(kd_commands_spawn(kd_world_commands(w, 0), &KD_TAG(knows), 1).generation, 0);
    kd_commands_set(kd_world_commands(w, 0), e[0], KD_TAG(knows));
    kd_world_merge(w);
    static const kd_component_desc both = {
        .name = "both", .align = 1, .flags = KD_COMPONENT_RELATION | KD_COMPONENT_TOGGLE};
    assert_int_equal(kd_component_ensure(w, &both), 0);
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(kd_entity_count(w), 2);
    assert_int_equal(kd_pair_count(w, knows), 0);
    kd_world_destroy(w);
}

static void an_exclusive_relation_has_one_target(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[4];
    spawn_all(w, e, 4);
    for (int i = 1; i < 4; i++) {
        assert_int_equal(kd_relate_with(w, e[0], aims_at, e[i], {(float)i}), KD_OK);
        assert_entity(kd_target(w, e[0], aims_at), e[i]);
        assert_int_equal(kd_sources(w, e[i - 1], aims_at).count, 0);
        assert_float_equal(kd_find(w, e[0], aims_at)->since, i, 0);
    }
    assert_int_equal(kd_relate_with(w, e[0], aims_at, e[3], {9}), KD_OK); /* the same: a new value */
    assert_int_equal(kd_pair_count(w, aims_at), 1);
    assert_float_equal(kd_pair_find(w, e[0], aims_at, e[3])->since, 9, 0);
    assert_int_equal(kd_relate_with(w, e[0], aims_at, e[0], {1}), KD_OK); /* itself */
    assert_entity(kd_sources(w, e[0], aims_at).at[0], e[0]);
    kd_destroy(w, e[0]);
    assert_int_equal(kd_pair_count(w, aims_at), 0);
    kd_world_destroy(w);
}

/* Targets keep their order whichever goes; sources fill the gap with the last. */
static void order_is_kept_as_documented(void **state)
{
    (void)state;
    enum { N = 300 };
    kd_world *w = kd_world_make();
    kd_entity e[N + 1];
    uint32_t left[N], count = N;
    uint64_t random = 7;
    spawn_all(w, e, N + 1);
    for (uint32_t i = 0; i < N; i++) {
        left[i] = i;
        assert_int_equal(kd_relate_with(w, e[N], likes, e[i], {(float)i, KD_NO_ENTITY}), KD_OK);
    }
    for (uint32_t turn = 0; turn < 2 * N && count; turn++) {
        uint32_t k = turn % 3 == 0 ? 0 : random_below(&random, count), gone = left[k];
        kd_unrelate(w, e[N], likes, e[gone]);
        memmove(left + k, left + k + 1, (--count - k) * sizeof *left);
        if (turn % 2) { /* some come back, at the end */
            kd_relate_with(w, e[N], likes, e[gone], {(float)gone, KD_NO_ENTITY});
            left[count++] = gone;
        }
        kd_entities targets = kd_targets(w, e[N], likes);
        assert_int_equal(targets.count, count);
        for (uint32_t i = 0; i < count; i++) {
            assert_entity(targets.at[i], e[left[i]]);
            assert_float_equal(kd_target_values(w, e[N], likes)[i].much, left[i], 0);
        }
    }
    for (int i = 0; i < 4; i++)
        kd_relate(w, e[i], knows, e[N]);
    kd_unrelate(w, e[1], knows, e[N]);
    kd_entities sources = kd_sources(w, e[N], knows);
    assert_int_equal(sources.count, 3);
    assert_entity(sources.at[0], e[0]);
    assert_entity(sources.at[1], e[3]);
    assert_entity(sources.at[2], e[2]);
    kd_world_destroy(w);
}

static void pairs_go_with_either_end(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[4];
    spawn_all(w, e, 4);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            kd_relate(w, e[i], knows, e[k]);
    kd_destroy(w, e[2]);
    assert_int_equal(kd_pair_count(w, knows), 9);
    kd_entity again = kd_spawn(w, KD_TAG(position)); /* the same index */
    assert_int_equal(again.index, e[2].index);
    assert_false(kd_related(w, e[0], knows, again));
    assert_false(kd_related(w, e[0], knows, e[2]));
    assert_int_equal(kd_sources(w, again, knows).count + kd_targets(w, again, knows).count, 0);
    kd_remove(w, e[0], knows); /* all it knows */
    assert_int_equal(kd_pair_count(w, knows), 6);
    assert_true(!kd_has(w, e[0], knows) && kd_has(w, e[1], knows));
    kd_query *all = kd_query_make(w, &(kd_query_desc){0});
    assert_int_equal(kd_destroy_query(all), KD_OK);
    assert_int_equal(kd_pair_count(w, knows), 0);
    kd_world_destroy(w);
}

static void sources_of_a_cascade_die_with_their_target(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[6];
    spawn_all(w, e, 6);
    kd_entity child = kd_spawn_child(w, e[1], KD_TAG(position));
    kd_relate(w, e[1], part_of, e[0]);
    kd_relate(w, e[2], part_of, child); /* through a child of a source */
    kd_relate(w, e[0], part_of, e[2]);  /* and round again */
    kd_relate(w, e[3], part_of, e[2]);
    kd_relate(w, e[4], knows, e[2]);
    kd_destroy(w, e[0]);
    assert_int_equal(kd_entity_count(w), 2);
    assert_true(kd_alive(w, e[4]) && kd_alive(w, e[5]));
    assert_int_equal(kd_pair_count(w, part_of) + kd_pair_count(w, knows), 0);
    /* A chain that is long: neither recursion nor memory. */
    kd_entity first = kd_spawn(w, KD_TAG(position)), last = first;
    for (int i = 0; i < 50000; i++) {
        kd_entity next = kd_spawn(w, KD_TAG(position));
        assert_int_equal(kd_relate(w, next, part_of, last), KD_OK);
        last = next;
    }
    kd_world_limit_bytes(w, 1);
    kd_destroy(w, first);
    assert_int_equal(kd_entity_count(w), 2);
    kd_world_destroy(w);
}

static void values_that_own_something_are_released(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[4];
    spawn_all(w, e, 4);
    owner_releases = 0;
    kd_relate_with(w, e[0], holds, e[1], {owned(1)});
    kd_relate_with(w, e[0], holds, e[1], {owned(2)}); /* set: 1 goes */
    assert_int_equal(owner_releases, 1);
    kd_relate_with(w, e[0], holds, e[2], {owned(3)}); /* another target: 2 goes */
    assert_int_equal(owner_releases, 2);
    assert_int_equal(*kd_find(w, e[0], holds)->memory, 3);
    kd_destroy(w, e[2]); /* the target: 3 goes */
    assert_int_equal(owner_releases, 3);
    kd_relate_with(w, e[0], holds, e[1], {owned(4)});
    kd_remove(w, e[0], holds);
    assert_int_equal(owner_releases, 4);
    kd_relate_with(w, e[0], holds, e[1], {owned(5)});
    kd_relate_with(w, e[3], holds, e[3], {owned(6)});
    kd_log_set_sink(silent, NULL);
    assert_int_equal(kd_clone(w, e[0]).generation, 0);
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(w);
    assert_int_equal(owner_releases, 6);
}

/* A value given to a call may be that of another pair, and moves while room is made. */
static void a_value_may_lie_in_the_relation_itself(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[200];
    spawn_all(w, e, 200);
    kd_relate_with(w, e[0], likes, e[1], {7, e[1]});
    for (uint32_t i = 1; i < 200; i++) {
        const likes *from = kd_find(w, e[i - 1], likes);
        assert_int_equal(kd_relate_value(w, e[i], (kd_value){&likes_desc, from}, e[(i + 1) % 200]), KD_OK);
        assert_float_equal(kd_find(w, e[i], likes)->much, 7, 0);
        assert_int_equal(kd_relate_value(w, e[0], (kd_value){&likes_desc, kd_find(w, e[0], likes)}, e[i]),
                         KD_OK);
        assert_entity(kd_pair_find(w, e[0], likes, e[i])->because_of, e[1]);
    }
    kd_world_destroy(w);
}

static void copies_relate_within_themselves(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[2], roots[3];
    spawn_all(w, e, 2);
    kd_entity root = kd_spawn(w, KD_TAG(position)), arm = kd_spawn_child(w, root, KD_TAG(position)),
              leg = kd_spawn_child(w, root, KD_TAG(velocity));
    kd_relate_with(w, arm, likes, e[0], {1, root});
    kd_relate_with(w, arm, likes, leg, {2, e[1]});
    kd_relate(w, leg, part_of, root);
    kd_relate(w, e[1], knows, arm); /* from outside: is not copied */
    assert_int_equal(kd_instantiate(w, root, KD_NO_ENTITY, 3, roots), KD_OK);
    for (int i = 0; i < 3; i++) {
        kd_entity arm_copy = kd_first_child(w, roots[i]), leg_copy = kd_next_sibling(w, arm_copy);
        kd_entities targets = kd_targets(w, arm_copy, likes);
        assert_int_equal(targets.count, 2);
        assert_entity(targets.at[0], e[0]);
        assert_entity(targets.at[1], leg_copy);
        assert_entity(kd_target_values(w, arm_copy, likes)[0].because_of, roots[i]);
        assert_entity(kd_target_values(w, arm_copy, likes)[1].because_of, e[1]);
        assert_entity(kd_target(w, leg_copy, part_of), roots[i]);
        assert_int_equal(kd_sources(w, arm_copy, knows).count, 0);
    }
    assert_int_equal(kd_sources(w, e[0], likes).count, 4);
    kd_world_destroy(w);
}

static void recorded_pairs_are_merged_in_order(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[2];
    spawn_all(w, e, 2);
    kd_relate(w, e[0], knows, e[1]);
    kd_commands *c = kd_world_commands(w, 0), *other = kd_world_commands(w, 1);
    kd_entity fresh = kd_commands_spawn(c, (kd_value[]){KD_TAG(position)}, 1);
    kd_commands_relate(c, fresh, KD_VAL(likes, {3, fresh}), e[0]);
    kd_commands_relate(c, e[0], KD_TAG(likes), fresh);
    kd_commands_unrelate(c, e[0], &knows_desc, e[1]);
    kd_commands_key(other, 1);
    kd_commands_relate(other, e[1], KD_VAL(aims_at, {1}), e[0]);
    kd_commands_key(c, 2);
    kd_commands_relate(c, e[1], KD_VAL(aims_at, {2}), fresh);
    assert_int_equal(kd_pair_count(w, likes), 0);
    assert_int_equal(kd_world_merge(w), KD_OK);
    fresh = kd_entity_resolve(w, fresh);
    assert_float_equal(kd_pair_find(w, fresh, likes, e[0])->much, 3, 0);
    assert_entity(kd_pair_find(w, fresh, likes, e[0])->because_of, fresh);
    assert_true(kd_related(w, e[0], likes, fresh) && !kd_related(w, e[0], knows, e[1]));
    assert_entity(kd_target(w, e[1], aims_at), fresh);
    kd_world_destroy(w);
}

typedef struct log_line {
    kd_event event;
    kd_entity source, target;
    float value;
} log_line;
static log_line lines[32];
static uint32_t line_count;
static void write_line(kd_world *w, const kd_observed *what, void *user)
{
    (void)w, (void)user;
    assert_true(line_count < 32);
    lines[line_count++] = (log_line){what->event, what->entity, what->target,
                                     what->value ? ((const aims_at *)what->value)->since : -1};
}
static void assert_line(uint32_t i, kd_event event, kd_entity source, kd_entity target, float value)
{
    assert_true(i < line_count);
    assert_int_equal(lines[i].event, event);
    assert_entity(lines[i].source, source);
    assert_entity(lines[i].target, target);
    assert_float_equal(lines[i].value, value, 0);
}

static void observers_are_told_of_pairs(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity e[4];
    spawn_all(w, e, 4);
    line_count = 0;
    uint32_t all = KD_ON_ADD | KD_ON_SET | KD_ON_REMOVE | KD_ON_DESTROY;
    assert_int_equal(kd_observe(w, &aims_at_desc, all, write_line, NULL), KD_OK);
    kd_relate_with(w, e[0], aims_at, e[1], {1});
    kd_relate_with(w, e[0], aims_at, e[1], {2});
    kd_relate_with(w, e[0], aims_at, e[2], {3});
    kd_destroy(w, e[2]);
    kd_relate_with(w, e[0], aims_at, e[3], {4});
    kd_entity copy = kd_clone(w, e[0]);
    kd_destroy(w, e[0]);
    assert_line(0, KD_ON_ADD, e[0], e[1], -1);
    assert_line(1, KD_ON_SET, e[0], e[1], -1);
    assert_line(2, KD_ON_REMOVE, e[0], e[1], 2);
    assert_line(3, KD_ON_ADD, e[0], e[2], -1);
    assert_line(4, KD_ON_REMOVE, e[0], e[2], 3);
    assert_line(5, KD_ON_ADD, e[0], e[3], -1);
    assert_line(6, KD_ON_ADD, copy, e[3], -1);
    assert_line(7, KD_ON_REMOVE, e[0], e[3], 4);
    assert_line(8, KD_ON_DESTROY, e[0], e[3], 4);
    assert_int_equal(line_count, 9);
    kd_world_destroy(w);
}

/* A popular target: whoever dies, in whichever order, the others are still found from both ends. */
static void a_popular_target_loses_sources_in_any_order(void **state)
{
    (void)state;
    enum { N = 4000 };
    static kd_entity e[N + 1];
    kd_world *w = kd_world_make();
    uint64_t random = 3;
    spawn_all(w, e, N + 1);
    for (uint32_t i = 0; i < N; i++)
        kd_relate_with(w, e[i], aims_at, e[N], {(float)i});
    for (uint32_t left = N; left > 0; left--) {
        uint32_t k = random_below(&random, left);
        kd_destroy(w, e[k]);
        e[k] = e[left - 1];
        if (left % 500 == 1)
            for (uint32_t i = 0; i < kd_sources(w, e[N], aims_at).count; i++)
                assert_entity(kd_target(w, kd_sources(w, e[N], aims_at).at[i], aims_at), e[N]);
        assert_int_equal(kd_sources(w, e[N], aims_at).count, left - 1);
    }
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pair_is_found_from_both_ends),
        cmocka_unit_test(misuse_is_refused_with_words),
        cmocka_unit_test(an_exclusive_relation_has_one_target),
        cmocka_unit_test(order_is_kept_as_documented),
        cmocka_unit_test(pairs_go_with_either_end),
        cmocka_unit_test(sources_of_a_cascade_die_with_their_target),
        cmocka_unit_test(values_that_own_something_are_released),
        cmocka_unit_test(a_value_may_lie_in_the_relation_itself),
        cmocka_unit_test(copies_relate_within_themselves),
        cmocka_unit_test(recorded_pairs_are_merged_in_order),
        cmocka_unit_test(observers_are_told_of_pairs),
        cmocka_unit_test(a_popular_target_loses_sources_in_any_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
