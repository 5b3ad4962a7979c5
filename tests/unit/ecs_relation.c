/* Relations: pairs are found from both ends, keep their order, go with either end, and are copied, recorded
 * and observed like components. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/snapshot_format.h"
#include "runtime/ecs/statistics.h"
#include "runtime/ecs/validate.h"
#include "tests/unit/ecs_fixture.h"

typedef struct likes {
    float much;
    kd_entity because_of;
} likes;
KD_RELATION_DEFINE(likes, "likes", 0, KD_FIELD(likes, much, KD_F32, NULL, "how much"),
                   KD_FIELD(likes, because_of, KD_ENTITY, NULL, "who made it so"));
typedef struct aims_at {
    float since;
} aims_at;
KD_RELATION_DEFINE(aims_at, "aims_at", KD_COMPONENT_EXCLUSIVE,
                   KD_FIELD(aims_at, since, KD_F32, "s", "when it began"));
typedef struct part_of part_of;
KD_RELATION_TAG_DEFINE(part_of, "part_of", KD_COMPONENT_EXCLUSIVE | KD_COMPONENT_CASCADE);
typedef struct knows knows;
KD_RELATION_TAG_DEFINE(knows, "knows", 0);
static const kd_component_desc holds_desc = {.name = "holds",
                                             .size = sizeof(owner),
                                             .align = _Alignof(owner),
                                             .on_remove = owner_release,
                                             .flags = KD_COMPONENT_RELATION | KD_COMPONENT_EXCLUSIVE};
typedef owner holds;

static bool slow(void)
{
    return getenv("KANDIL_SLOW") && *getenv("KANDIL_SLOW") == '1';
}

static void spawn_all(kd_world *w, kd_entity *e, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        e[i] = kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}));
}

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

/* ---- queries ---- */
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

/* ---- the world as a whole ---- */
static kd_world *related_world(kd_entity *e, uint32_t n)
{
    kd_world *w = kd_world_make();
    uint64_t random = 11;
    spawn_all(w, e, n);
    for (uint32_t i = 0; i < 6 * n; i++) {
        kd_entity a = e[random_below(&random, n)], b = e[random_below(&random, n)];
        switch (i % 6) {
        case 0:
        case 1: kd_relate_with(w, a, likes, b, {(float)i, e[0]}); break;
        case 2: kd_relate_with(w, a, aims_at, b, {(float)i}); break;
        case 3: kd_relate(w, a, knows, b); break;
        case 4:
            if (a.index > b.index)
                kd_relate(w, a, part_of, b);
            break;
        default: kd_unrelate(w, a, likes, kd_target(w, a, likes)); kd_remove(w, b, knows);
        }
    }
    kd_destroy(w, e[n / 2]);
    assert_int_equal(kd_world_validate(w), KD_OK);
    return w;
}

static void register_relations(kd_world *w)
{
    const kd_component_desc *const all[] = {&part_of_desc, &knows_desc, &aims_at_desc,
                                            &likes_desc,   &holds_desc, &position_desc};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        assert_true(kd_component_ensure(w, all[i]) != 0);
}

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

/* Bytes that are wrong but bear a right checksum: refused, or a world in which everything agrees. */
static void hostile_pairs_never_break_a_world(void **state)
{
    (void)state;
    kd_entity e[24];
    kd_world *w = related_world(e, 24), *victim = kd_world_make();
    kd_snapshot s = {0};
    uint64_t random = 5;
    uint32_t restored = 0, refused = 0;
    register_relations(victim);
    kd_spawn(victim, KD_TAG(position));
    assert_int_equal(kd_snapshot_write(w, &s), KD_OK);
    kd_log_set_sink(silent, NULL);
    uint8_t *bytes = malloc(s.size);
    assert_non_null(bytes);
    const uint8_t values[] = {0, 1, 2, 23, 24, 0x7f, 0x80, 0xff};
    for (uint32_t round = 0; round < (slow() ? 100000u : 5000u); round++) {
        memcpy(bytes, s.data, s.size);
        /* relations lie at the end: the last third is hit most */
        size_t from = round % 4 ? s.size - s.size / 3 : sizeof(snapshot_header);
        for (uint32_t k = 0; k < 1 + round % 3; k++)
            bytes[from + random_u32(&random) % (s.size - from)] = values[random_below(&random, 8)];
        uint64_t checksum = XXH3_64bits(bytes + SNAPSHOT_HASHED, s.size - SNAPSHOT_HASHED);
        memcpy(bytes + offsetof(snapshot_header, checksum), &checksum, sizeof checksum);
        kd_status status = kd_snapshot_restore(victim, bytes, s.size);
        *(status ? &refused : &restored) += 1;
        if (!status)
            assert_int_equal(kd_world_validate(victim), KD_OK);
    }
    assert_true(refused > 500 && restored > 500);
    assert_int_equal(kd_world_validate(victim), KD_OK);
    kd_log_set_sink(NULL, NULL);
    free(bytes);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
    kd_world_destroy(victim);
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
        cmocka_unit_test(queries_ask_for_any_target_or_for_one),
        cmocka_unit_test(queries_by_depth_show_parents_first),
        cmocka_unit_test(columns_of_pairs_are_arrays),
        cmocka_unit_test(changes_of_pairs_are_seen),
        cmocka_unit_test(snapshots_carry_pairs_in_both_orders),
        cmocka_unit_test(hostile_pairs_never_break_a_world),
        cmocka_unit_test(differences_of_pairs_are_named),
        cmocka_unit_test(json_and_statistics_show_pairs),
        cmocka_unit_test(a_pair_takes_few_bytes_and_gives_them_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
