/* Parents, ordered children, depth. */

#include "tests/unit/ecs_fixture.h"

static int make(void **state)
{
    *state = kd_world_make();
    return *state ? 0 : -1;
}
static int drop(void **state)
{
    kd_world_destroy(*state);
    return 0;
}

static void check_children(kd_world *w, kd_entity parent, const kd_entity *children, uint32_t count)
{
    kd_entity at = kd_first_child(w, parent);
    for (uint32_t i = 0; i < count; i++, at = kd_next_sibling(w, at)) {
        assert_entity(at, children[i]);
        assert_entity(kd_get_parent(w, at), parent);
        assert_int_equal(kd_get_depth(w, at), kd_get_depth(w, parent) + 1);
    }
    assert_entity(at, KD_NO_ENTITY);
}

static void children_keep_the_order_in_which_they_came(void **state)
{
    kd_world *w = *state;
    kd_entity root = kd_spawn(w, KD_TAG(position)), c[4];
    for (int i = 0; i < 4; i++) {
        c[i] = kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}));
        assert_int_equal(kd_set_parent(w, c[i], root), KD_OK);
    }
    check_children(w, root, c, 4);
    kd_destroy(w, c[1]);
    check_children(w, root, (kd_entity[]){c[0], c[2], c[3]}, 3);
    kd_set_parent(w, c[0], root); /* again: goes to the end */
    check_children(w, root, (kd_entity[]){c[2], c[3], c[0]}, 3);
    kd_set_parent(w, c[3], KD_NO_ENTITY);
    check_children(w, root, (kd_entity[]){c[2], c[0]}, 2);
    assert_int_equal(kd_get_depth(w, c[3]), 0);
    assert_entity(kd_get_parent(w, c[3]), KD_NO_ENTITY);
    assert_true(kd_find(w, c[0], position)->x == 0 && kd_find(w, c[2], position)->x == 2);
    assert_int_equal(kd_set_parent(w, c[3], KD_NO_ENTITY), KD_OK); /* an orphan already */
}

static void child_may_be_spawned_in_its_place(void **state)
{
    kd_world *w = *state;
    kd_entity root = kd_spawn(w, KD_TAG(position)), c[3];
    for (int i = 0; i < 3; i++)
        c[i] = kd_spawn_child(w, root, KD_VAL(position, {(float)i, 0, 0}), KD_TAG(frozen));
    kd_entity grandchild = kd_spawn_child(w, c[1], KD_TAG(position));
    check_children(w, root, c, 3);
    check_children(w, c[1], &grandchild, 1);
    assert_true(kd_find(w, c[2], position)->x == 2 && kd_has(w, c[2], frozen));
    kd_destroy(w, c[1]);
    assert_false(kd_alive(w, grandchild));
    assert_entity(kd_spawn_child(w, c[1], KD_TAG(position)), KD_NO_ENTITY);
    assert_int_equal(kd_entity_count(w), 3);
}

static void children_stay_when_components_come_and_go(void **state)
{
    kd_world *w = *state;
    kd_entity root = kd_spawn(w, KD_TAG(position)), c[3];
    for (int i = 0; i < 3; i++) {
        c[i] = kd_spawn(w, KD_TAG(position));
        kd_set_parent(w, c[i], root);
    }
    kd_add(w, root, frozen);
    kd_add(w, c[1], health);
    kd_remove(w, c[0], position);
    check_children(w, root, c, 3);
}

static void cycles_are_refused(void **state)
{
    kd_world *w = *state;
    kd_entity a = kd_spawn(w, KD_TAG(position)), b = kd_spawn(w, KD_TAG(position)),
              c = kd_spawn(w, KD_TAG(position));
    assert_int_equal(kd_set_parent(w, a, a), KD_OUT_OF_RANGE);
    assert_int_equal(kd_set_parent(w, b, a), KD_OK);
    assert_int_equal(kd_set_parent(w, c, b), KD_OK);
    assert_int_equal(kd_set_parent(w, a, c), KD_OUT_OF_RANGE);
    assert_int_equal(kd_set_parent(w, a, b), KD_OUT_OF_RANGE);
    assert_int_equal(kd_get_depth(w, c), 2);
    assert_entity(kd_get_parent(w, a), KD_NO_ENTITY);
}

static void dead_parents_are_refused(void **state)
{
    kd_world *w = *state;
    kd_entity a = kd_spawn(w, KD_TAG(position)), b = kd_spawn(w, KD_TAG(position));
    kd_destroy(w, a);
    assert_int_equal(kd_set_parent(w, b, a), KD_NOT_FOUND);
    assert_int_equal(kd_set_parent(w, a, b), KD_NOT_FOUND);
}

static void subtree_changes_depth_with_its_root(void **state)
{
    kd_world *w = *state;
    kd_entity chain[6], other[3];
    for (int i = 0; i < 6; i++) {
        chain[i] = i & 1 ? kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}))
                         : kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}), KD_TAG(health));
        if (i)
            kd_set_parent(w, chain[i], chain[i - 1]);
    }
    for (int i = 0; i < 3; i++) {
        other[i] = kd_spawn(w, KD_TAG(position));
        if (i)
            kd_set_parent(w, other[i], other[i - 1]);
    }
    assert_int_equal(kd_set_parent(w, chain[2], other[2]), KD_OK); /* from depth 2 to 3 */
    assert_int_equal(kd_get_depth(w, chain[5]), 6);
    assert_int_equal(kd_set_parent(w, chain[2], KD_NO_ENTITY), KD_OK);
    assert_int_equal(kd_get_depth(w, chain[5]), 3);
    for (int i = 0; i < 6; i++)
        assert_true(kd_find(w, chain[i], position)->x == (float)i);
    assert_entity(kd_get_parent(w, chain[5]), chain[4]);
    assert_int_equal(kd_get_depth(w, chain[1]), 1);
}

static void destroying_a_parent_destroys_all_below(void **state)
{
    kd_world *w = *state;
    enum { N = 500 };
    kd_entity e[N];
    uint64_t random = 3;
    owner_releases = 0;
    kd_entity stays = kd_spawn(w, KD_TAG(position));
    for (uint32_t i = 0; i < N; i++) {
        e[i] = kd_spawn(w, KD_VAL(owner, {owned((int)i)}));
        if (i)
            kd_set_parent(w, e[i], e[random_below(&random, i)]);
    }
    kd_set_parent(w, e[0], stays);
    kd_destroy(w, e[0]);
    assert_int_equal(kd_entity_count(w), 1);
    assert_int_equal(owner_releases, N);
    assert_entity(kd_first_child(w, stays), KD_NO_ENTITY);
    for (uint32_t i = 0; i < N; i++)
        assert_false(kd_alive(w, e[i]));
}

static void long_chain_needs_no_stack(void **state)
{
    kd_world *w = *state;
    enum { N = 3000 };
    static kd_entity e[N];
    for (uint32_t i = 0; i < N; i++) {
        e[i] = kd_spawn(w, KD_TAG(frozen));
        if (i)
            assert_int_equal(kd_set_parent(w, e[i], e[i - 1]), KD_OK);
    }
    assert_int_equal(kd_get_depth(w, e[N - 1]), N - 1);
    kd_entity root = kd_spawn(w, KD_TAG(frozen));
    assert_int_equal(kd_set_parent(w, e[0], root), KD_OK);
    assert_int_equal(kd_get_depth(w, e[N - 1]), N);
    kd_destroy(w, root);
    assert_int_equal(kd_entity_count(w), 0);
}

static void reparenting_out_of_memory_changes_nothing(void **state)
{
    kd_world *w = *state;
    enum { N = 600 };
    static kd_entity e[N];
    kd_entity root = kd_spawn(w, KD_TAG(position)), below = kd_spawn(w, KD_TAG(position));
    kd_set_parent(w, below, root);
    for (uint32_t i = 0; i < N; i++) {
        e[i] = kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}), KD_TAG(velocity), KD_TAG(health));
        if (i)
            kd_set_parent(w, e[i], e[(i - 1) / 2]);
    }
    uint64_t before = kd_world_checksum(w);
    int failures = 0;
    for (size_t room = 64;; room += 512) {
        kd_world_limit_bytes(w, kd_world_bytes(w) + room);
        kd_status status = kd_set_parent(w, e[0], below);
        if (status == KD_OK)
            break;
        failures++;
        assert_int_equal(status, KD_NO_MEMORY);
        assert_true(kd_world_checksum(w) == before);
    }
    assert_true(failures > 2);
    for (uint32_t i = 0; i < N; i++)
        assert_true(kd_find(w, e[i], position)->x == (float)i);
    assert_int_equal(kd_get_depth(w, e[0]), 2);
}

/* A query shows the parents of its rows: who looks at changes alone must see a child that moved to a cousin's
 * place. Its row moves nowhere. */
static void another_parent_counts_as_a_change(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity a = kd_spawn(w, KD_TAG(velocity)), b = kd_spawn(w, KD_TAG(velocity));
    kd_entity child = kd_spawn_child(w, a, KD_TAG(position));
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    uint64_t since = kd_world_version(w);
    kd_iter it = kd_query_iter(q);
    it.changed_since = since;
    assert_false(kd_iter_next(&it));
    assert_int_equal(kd_set_parent(w, child, b), KD_OK);
    it = kd_query_iter(q);
    it.changed_since = since;
    assert_true(kd_iter_next(&it));
    assert_entity(it.parents[0], b);
    kd_world_destroy(w);
}

int main(void)
{
#define CASE(test) cmocka_unit_test_setup_teardown(test, make, drop)
    const struct CMUnitTest tests[] = {
        CASE(children_keep_the_order_in_which_they_came),
        CASE(child_may_be_spawned_in_its_place),
        CASE(children_stay_when_components_come_and_go),
        CASE(cycles_are_refused),
        CASE(dead_parents_are_refused),
        CASE(subtree_changes_depth_with_its_root),
        CASE(destroying_a_parent_destroys_all_below),
        CASE(long_chain_needs_no_stack),
        CASE(reparenting_out_of_memory_changes_nothing),
        cmocka_unit_test(another_parent_counts_as_a_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
