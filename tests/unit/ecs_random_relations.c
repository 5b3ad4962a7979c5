/* Random programs that relate entities, against plain arrays: both directions in their exact order, values,
 * deaths that spread, copies, commands, queries by target, snapshots. KANDIL_SLOW=1 runs more of them. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/validate.h"
#include "tests/unit/ecs_fixture.h"

enum { MOST = 500, RELATIONS = 4, MOST_NODES = 20 };
enum { LIKES, AIMS, PART, KNOWS };

typedef struct likes {
    int32_t number;
} likes;
KD_RELATION_DEFINE(likes, "likes", 0, KD_FIELD(likes, number, KD_I32, NULL, "any"));
typedef struct aims {
    int32_t number, other;
} aims;
KD_RELATION_DEFINE(aims, "aims", KD_COMPONENT_EXCLUSIVE, KD_FIELD(aims, number, KD_I32, NULL, "any"),
                   KD_FIELD(aims, other, KD_I32, NULL, "any"));
KD_RELATION_TAG_DEFINE(part, "part", KD_COMPONENT_EXCLUSIVE | KD_COMPONENT_CASCADE);
KD_RELATION_TAG_DEFINE(knows, "knows", 0);
static const kd_component_desc *const kinds[RELATIONS] = {&likes_desc, &aims_desc, &part_desc, &knows_desc};

typedef struct list {
    int count, at[MOST], numbers[MOST]; /* numbers: of targets, their values */
} list;

typedef struct model {
    kd_world *w;
    kd_component_id ids[RELATIONS];
    kd_entity handles[MOST];
    bool alive[MOST];
    int parent[MOST], count, doomed[MOST * MOST], doomed_count;
    list children[MOST];
    list targets[RELATIONS][MOST], sources[RELATIONS][MOST];
    kd_query *any, *by_depth;
    uint64_t random;
} model;

/* ---- lists ---- */
static int place_in(const list *l, int e)
{
    for (int i = 0; i < l->count; i++)
        if (l->at[i] == e)
            return i;
    return -1;
}

static void append(list *l, int e, int number)
{
    l->at[l->count] = e;
    l->numbers[l->count++] = number;
}

static void take_in_order(list *l, int place)
{
    l->count--;
    for (int i = place; i < l->count; i++) {
        l->at[i] = l->at[i + 1];
        l->numbers[i] = l->numbers[i + 1];
    }
}

static void take_by_last(list *l, int place)
{
    l->at[place] = l->at[--l->count];
}

static bool exclusive(int r)
{
    return r == AIMS || r == PART;
}

/* ---- the model's moves ---- */
static void model_unrelate(model *m, int r, int source, int target)
{
    take_in_order(&m->targets[r][source], place_in(&m->targets[r][source], target));
    take_by_last(&m->sources[r][target], place_in(&m->sources[r][target], source));
}

static void model_relate(model *m, int r, int source, int target, int number)
{
    int place = place_in(&m->targets[r][source], target);
    if (place >= 0) {
        m->targets[r][source].numbers[place] = number;
        return;
    }
    if (exclusive(r) && m->targets[r][source].count)
        model_unrelate(m, r, source, m->targets[r][source].at[0]);
    append(&m->targets[r][source], target, number);
    append(&m->sources[r][target], source, 0);
}

static void model_die(model *m, int e)
{
    while (m->children[e].count)
        model_die(m, m->children[e].at[0]);
    if (m->parent[e] >= 0)
        take_in_order(&m->children[m->parent[e]], place_in(&m->children[m->parent[e]], e));
    for (int r = 0; r < RELATIONS; r++) {
        while (m->targets[r][e].count)
            model_unrelate(m, r, e, m->targets[r][e].at[0]);
        for (int i = 0; r == PART && i < m->sources[r][e].count; i++)
            m->doomed[m->doomed_count++] = m->sources[r][e].at[i];
        while (m->sources[r][e].count)
            model_unrelate(m, r, m->sources[r][e].at[m->sources[r][e].count - 1], e);
    }
    m->alive[e] = false;
}

static void model_destroy(model *m, int e)
{
    m->doomed_count = 0;
    model_die(m, e);
    for (int i = 0; i < m->doomed_count; i++)
        if (m->alive[m->doomed[i]])
            model_die(m, m->doomed[i]);
}

static int model_add(model *m, kd_entity handle, int parent)
{
    int e = m->count++;
    assert_true(kd_alive(m->w, handle));
    m->handles[e] = handle;
    m->alive[e] = true;
    m->parent[e] = parent;
    if (parent >= 0)
        append(&m->children[parent], e, 0);
    return e;
}

static int pick(model *m)
{
    return (int)random_below(&m->random, (uint32_t)m->count);
}

static int pick_alive(model *m)
{
    for (int tries = 0; tries < 60; tries++) {
        int e = pick(m);
        if (m->alive[e])
            return e;
    }
    return -1;
}

/* Few targets are popular, so that lists grow long. */
static int pick_target(model *m)
{
    int e = (int)random_below(&m->random, 2 + (uint32_t)m->count / 20);
    return e < m->count && random_below(&m->random, 2) ? e : pick(m);
}

/* ---- operations on both ---- */
static void op_spawn(model *m)
{
    int parent = m->count && random_below(&m->random, 3) == 0 ? pick_alive(m) : -1;
    if (m->count == MOST)
        return;
    kd_entity e = parent < 0    ? kd_spawn(m->w, KD_TAG(position))
                  : pick(m) % 2 ? kd_spawn_child(m->w, m->handles[parent], KD_TAG(position))
                                : kd_spawn_child(m->w, m->handles[parent], KD_TAG(health));
    model_add(m, e, parent);
}

static kd_value value_of(int r, int number, likes *l, aims *a)
{
    *l = (likes){number};
    *a = (aims){number, -number};
    return (kd_value){kinds[r], r == LIKES ? (const void *)l : r == AIMS ? (const void *)a : NULL};
}

static void op_relate(model *m)
{
    int r = (int)random_below(&m->random, RELATIONS), source = pick(m), target = pick_target(m);
    int number = (int)random_below(&m->random, 1000);
    bool living = m->alive[source] && m->alive[target], deferred = random_below(&m->random, 4) == 0;
    likes l;
    aims a;
    kd_value value = value_of(r, number, &l, &a);
    if (r == PART && random_below(&m->random, 3))
        return; /* else everybody dies at once */
    if (deferred) {
        kd_commands_relate(kd_world_commands(m->w, 3), m->handles[source], value, m->handles[target]);
        assert_int_equal(kd_world_merge(m->w), KD_OK);
    } else {
        assert_int_equal(kd_relate_value(m->w, m->handles[source], value, m->handles[target]),
                         living ? KD_OK : KD_NOT_FOUND);
    }
    if (living)
        model_relate(m, r, source, target, number);
}

static void op_unrelate(model *m)
{
    int r = (int)random_below(&m->random, RELATIONS), source = pick(m), target = pick_target(m);
    const list *l = &m->targets[r][source];
    if (l->count && random_below(&m->random, 4)) /* mostly one that is there */
        target = l->at[random_below(&m->random, (uint32_t)l->count)];
    if (random_below(&m->random, 4) == 0) {
        kd_commands_unrelate(kd_world_commands(m->w, 0), m->handles[source], kinds[r], m->handles[target]);
        assert_int_equal(kd_world_merge(m->w), KD_OK);
    } else {
        kd_unrelate_id(m->w, m->handles[source], m->ids[r], m->handles[target]);
    }
    if (m->alive[source] && place_in(l, target) >= 0)
        model_unrelate(m, r, source, target);
}

static void op_remove(model *m)
{
    int r = (int)random_below(&m->random, RELATIONS), source = pick(m);
    kd_remove_id(m->w, m->handles[source], m->ids[r]);
    while (m->targets[r][source].count)
        model_unrelate(m, r, source, m->targets[r][source].at[0]);
}

static void op_destroy(model *m)
{
    int e = pick(m);
    kd_destroy(m->w, m->handles[e]);
    if (m->alive[e])
        model_destroy(m, e);
}

static void op_destroy_query(model *m)
{
    int target = pick_alive(m);
    if (target < 0)
        return;
    kd_query *q = kd_query_make(m->w, &(kd_query_desc){.terms = {KD_PAIR(aims, m->handles[target])}});
    list doomed = m->sources[AIMS][target];
    assert_int_equal(kd_destroy_query(q), KD_OK);
    for (int i = 0; i < doomed.count; i++)
        if (m->alive[doomed.at[i]])
            model_destroy(m, doomed.at[i]);
    kd_query_destroy(q);
}

static int subtree(const model *m, int root, int *nodes, int room)
{
    int count = 1;
    if (!room)
        return MOST_NODES + 1;
    nodes[0] = root;
    for (int i = 0; i < m->children[root].count && count <= MOST_NODES; i++)
        count += subtree(m, m->children[root].at[i], nodes + count, room - count);
    return count;
}

static void op_instantiate(model *m)
{
    int nodes[MOST_NODES], copies[MOST_NODES][2], root = pick_alive(m);
    kd_entity roots[2];
    int count = root < 0 ? MOST_NODES + 1 : subtree(m, root, nodes, MOST_NODES);
    if (count > MOST_NODES || m->count + 2 * count > MOST)
        return;
    assert_int_equal(kd_instantiate(m->w, m->handles[root], KD_NO_ENTITY, 2, roots), KD_OK);
    for (int i = 0; i < 2; i++)
        for (int k = 0, from; k < count; k++) {
            kd_entity handle = roots[i];
            for (from = 0; k && nodes[from] != m->parent[nodes[k]]; from++) {
            }
            if (k) {
                handle = kd_first_child(m->w, m->handles[copies[from][i]]);
                for (int before = place_in(&m->children[nodes[from]], nodes[k]); before > 0; before--)
                    handle = kd_next_sibling(m->w, handle);
            }
            copies[k][i] = model_add(m, handle, k ? copies[from][i] : -1);
        }
    for (int k = 0; k < count; k++)
        for (int r = 0; r < RELATIONS; r++)
            for (int i = 0; i < 2; i++) {
                list from = m->targets[r][nodes[k]];
                for (int t = 0; t < from.count; t++) {
                    int target = from.at[t];
                    for (int n = 0; n < count; n++)
                        target = from.at[t] == nodes[n] ? copies[n][i] : target;
                    model_relate(m, r, copies[k][i], target, from.numbers[t]);
                }
            }
}

static void op_snapshot(model *m)
{
    kd_snapshot s = {0};
    uint64_t before = kd_world_checksum(m->w);
    assert_int_equal(kd_snapshot_write(m->w, &s), KD_OK);
    kd_world *other = kd_world_make();
    kd_component_ensure(other, &health_desc);
    kd_component_ensure(other, &position_desc);
    for (int r = RELATIONS; r-- > 0;)
        kd_component_ensure(other, kinds[r]);
    assert_int_equal(kd_snapshot_restore(other, s.data, s.size), KD_OK);
    assert_int_equal(kd_world_diff(m->w, other, NULL, 0), 0);
    assert_int_equal(kd_world_validate(other), KD_OK);
    kd_world_destroy(other);
    for (int e = 0; e < m->count && e < 5; e++)
        kd_destroy(m->w, m->handles[e]);
    assert_int_equal(kd_snapshot_restore(m->w, s.data, s.size), KD_OK);
    assert_true(kd_world_checksum(m->w) == before);
    kd_snapshot_fini(&s);
}

/* ---- comparison ---- */
static void check_list(const model *m, kd_entities shown, const list *l)
{
    assert_int_equal(shown.count, l->count);
    for (int i = 0; i < l->count; i++)
        assert_entity(shown.at[i], m->handles[l->at[i]]);
}

static void check_entity(const model *m, int e)
{
    assert_int_equal(kd_alive(m->w, m->handles[e]), m->alive[e]);
    for (int r = 0; r < RELATIONS; r++) {
        const list *l = &m->targets[r][e];
        const int32_t *values = kd_target_values_id(m->w, m->handles[e], m->ids[r]);
        check_list(m, kd_targets_id(m->w, m->handles[e], m->ids[r]), l);
        check_list(m, kd_sources_id(m->w, m->handles[e], m->ids[r]), &m->sources[r][e]);
        assert_int_equal(kd_find_id(m->w, m->handles[e], m->ids[r]) != NULL, l->count > 0);
        for (int i = 0; i < l->count && r <= AIMS; i++) {
            assert_int_equal(values[i * (r + 1)], l->numbers[i]);
            assert_ptr_equal(kd_pair_find_id(m->w, m->handles[e], m->ids[r], m->handles[l->at[i]]),
                             values + i * (r + 1));
        }
    }
}

/* Who has a position and knows the target, in the order of relating; and who likes anybody, at any place. */
static void check_queries(model *m)
{
    int target = pick(m), at = 0, rows = 0, expected = 0;
    const list *l = &m->sources[KNOWS][target];
    for (kd_iter it = kd_query_iter_to(m->any, m->handles[target]); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++, at++) {
            while (at < l->count && !kd_has(m->w, m->handles[l->at[at]], position))
                at++;
            assert_true(at < l->count);
            assert_entity(it.entities[i], m->handles[l->at[at]]);
        }
    while (at < l->count && !kd_has(m->w, m->handles[l->at[at]], position))
        at++;
    assert_int_equal(at, l->count);
    uint32_t depth = 0;
    for (kd_iter it = kd_query_iter_to(m->by_depth, m->handles[target]); kd_iter_next(&it);
         rows += (int)it.count) {
        assert_true(kd_get_depth(m->w, it.entities[0]) >= depth);
        depth = kd_get_depth(m->w, it.entities[0]);
        const aims *a = KD_COLUMN(&it, aims, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            assert_true(a[i].other == -a[i].number);
            assert_true(kd_pair_find(m->w, it.entities[i], aims, m->handles[target]) == &a[i]);
            assert_entity(kd_iter_targets(&it, 0)[i], m->handles[target]);
        }
    }
    assert_int_equal(rows, m->sources[AIMS][target].count);
    rows = 0;
    for (kd_iter it = kd_query_iter(m->by_depth); kd_iter_next(&it); rows += (int)it.count)
        for (uint32_t i = 0; i < it.count; i++)
            assert_entity(kd_iter_targets(&it, 0)[i], kd_target(m->w, it.entities[i], aims));
    for (int e = 0; e < m->count; e++)
        expected += m->targets[AIMS][e].count;
    assert_int_equal(rows, expected);
    assert_int_equal(kd_pair_count(m->w, aims), expected);
}

static void check_all(model *m)
{
    for (int e = 0; e < m->count; e++)
        check_entity(m, e);
    for (int i = 0; i < 10; i++)
        check_queries(m);
    assert_int_equal(kd_world_validate(m->w), KD_OK);
}

static uint64_t run_program(uint64_t seed, int steps, int check_every)
{
    static model m;
    memset(&m, 0, sizeof m);
    m.random = seed * 0x9e3779b97f4a7c15u + 1;
    m.w = kd_world_make();
    assert_non_null(m.w);
    for (int r = 0; r < RELATIONS; r++)
        m.ids[r] = kd_component_ensure(m.w, kinds[r]);
    m.any = kd_query_make(m.w, &(kd_query_desc){.terms = {KD_WITH(knows), KD_READ(position)}});
    m.by_depth = kd_query_make(m.w, &(kd_query_desc){.terms = {KD_READ(aims)}, .by_depth = true});
    for (int i = 0; i < steps; i++) {
        uint32_t op = random_below(&m.random, 100);
        if (m.count < 10 || op < 15)
            op_spawn(&m);
        else if (op < 70)
            op_relate(&m);
        else if (op < 86)
            op_unrelate(&m);
        else if (op < 90)
            op_remove(&m);
        else if (op < 96)
            op_destroy(&m);
        else if (op < 98)
            op_instantiate(&m);
        else if (op == 98)
            op_destroy_query(&m);
        else if (check_every)
            op_snapshot(&m);
        if (check_every && i % check_every == 0)
            check_all(&m);
    }
    if (check_every)
        check_all(&m);
    uint64_t checksum = kd_world_checksum(m.w);
    kd_world_destroy(m.w);
    return checksum;
}

static bool slow(void)
{
    return getenv("KANDIL_SLOW") && *getenv("KANDIL_SLOW") == '1';
}

static void random_relations_agree_with_the_model(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= (slow() ? 3000u : 60u); seed++)
        run_program(seed, 1200, 100);
}

static void random_relations_repeat_exactly(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 10; seed++)
        assert_true(run_program(seed, 1000, 0) == run_program(seed, 1000, 0));
    assert_true(run_program(1, 1000, 0) != run_program(2, 1000, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_relations_agree_with_the_model),
        cmocka_unit_test(random_relations_repeat_exactly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
