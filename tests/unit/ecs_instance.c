/* Copies of subtrees and many deaths at once; ecs_random.c compares both with a model. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "tests/unit/ecs_fixture.h"

/* root with two arms; the second arm points to the first, the first to somebody outside. */
static kd_entity prototype(kd_world *w, kd_entity outside)
{
    kd_entity root = kd_spawn(w, KD_VAL(position, {1, 2, 3}));
    kd_entity one = kd_spawn_child(w, root, KD_VAL(bond, {outside, 1}));
    kd_entity two = kd_spawn_child(w, root, KD_VAL(bond, {one, 2}), KD_TAG(frozen));
    kd_set_name(w, root, "body");
    kd_set_name(w, two, "arm");
    return root;
}

static void copies_hold_what_the_prototype_holds(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity outside = kd_spawn(w, KD_TAG(health)), root = prototype(w, outside), copies[50];
    assert_int_equal(kd_instantiate(w, root, outside, 50, copies), KD_OK);
    assert_int_equal(kd_entity_count(w), 1 + 3 + 50 * 3);
    kd_entity sibling = kd_first_child(w, outside);
    for (int i = 0; i < 50; i++) {
        kd_entity one = kd_first_child(w, copies[i]), two = kd_next_sibling(w, one);
        assert_entity(copies[i], sibling); /* in order below the parent */
        assert_true(kd_find(w, copies[i], position)->z == 3);
        assert_string_equal(kd_get_name(w, copies[i]), "body");
        assert_string_equal(kd_get_name(w, two), "arm");
        assert_int_equal(kd_get_depth(w, two), 2);
        assert_true(kd_has(w, two, frozen) && !kd_has(w, one, frozen));
        assert_entity(kd_find(w, one, bond)->target, outside);
        assert_entity(kd_find(w, two, bond)->target, one); /* the copy's own arm */
        sibling = kd_next_sibling(w, sibling);
    }
    assert_entity(kd_find(w, kd_next_sibling(w, kd_first_child(w, root)), bond)->target,
                  kd_first_child(w, root));
    kd_world_destroy(w);
}

static void a_clone_stands_beside_the_original(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity root = prototype(w, KD_NO_ENTITY), one = kd_first_child(w, root);
    kd_entity copy = kd_clone(w, one);
    assert_entity(kd_get_parent(w, copy), root);
    assert_entity(kd_next_sibling(w, kd_next_sibling(w, one)), copy);
    kd_entity whole = kd_clone(w, root);
    assert_entity(kd_get_parent(w, whole), KD_NO_ENTITY);
    assert_int_equal(kd_entity_count(w), 8);
    assert_entity(kd_clone(w, KD_NO_ENTITY), KD_NO_ENTITY);
    kd_world_destroy(w);
}

static void a_copy_below_itself_ends(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity root = prototype(w, KD_NO_ENTITY), copy;
    assert_int_equal(kd_instantiate(w, root, kd_first_child(w, root), 1, &copy), KD_OK);
    assert_int_equal(kd_entity_count(w), 6);
    assert_int_equal(kd_get_depth(w, kd_first_child(w, copy)), 3);
    kd_world_destroy(w);
}

static void what_owns_memory_is_not_copied(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    owner o = {owned(1)};
    kd_entity root = prototype(w, KD_NO_ENTITY);
    kd_spawn_child(w, root, ((kd_value){&owner_desc, &o}));
    kd_log_set_sink(silent, NULL);
    int errors = kd_log_count(KD_LOG_ERROR);
    assert_int_equal(kd_instantiate(w, root, KD_NO_ENTITY, 3, NULL), KD_UNSUPPORTED);
    assert_int_equal(kd_log_count(KD_LOG_ERROR), errors + 1);
    assert_int_equal(kd_entity_count(w), 4);
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(w);
}

static void without_memory_no_copy_is_left(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity root = prototype(w, KD_NO_ENTITY);
    kd_status status = KD_NO_MEMORY;
    for (uint32_t round = 0; status; round++) {
        uint64_t before = kd_world_checksum(w);
        kd_world_limit_bytes(w, kd_world_bytes(w) + round * 512);
        status = kd_instantiate(w, root, KD_NO_ENTITY, 300, NULL);
        if (status) {
            assert_int_equal(status, KD_NO_MEMORY);
            assert_int_equal(kd_entity_count(w), 3);
            assert_true(kd_world_checksum(w) == before);
        }
    }
    assert_int_equal(kd_entity_count(w), 903);
    kd_world_destroy(w);
}

static uint32_t told;
static void count_events(kd_world *w, const kd_observed *what, void *user)
{
    (void)user;
    told += what->event == KD_ON_ADD ? kd_alive(w, what->entity) : 100;
}

static void observers_hear_of_copies_and_deaths(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity root = prototype(w, KD_NO_ENTITY), copies[4];
    told = 0;
    kd_observe(w, &bond_desc, KD_ON_ADD | KD_ON_DESTROY, count_events, NULL);
    kd_instantiate(w, root, KD_NO_ENTITY, 4, copies);
    assert_int_equal(told, 8);
    kd_destroy_n(w, copies, 4);
    assert_int_equal(told, 808);
    assert_int_equal(kd_entity_count(w), 3);
    kd_world_destroy(w);
}

static void a_query_destroys_what_it_matches(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity keep = kd_spawn(w, KD_TAG(health)), first = KD_NO_ENTITY;
    for (int i = 0; i < 1000; i++) {
        kd_entity e = i % 2 ? kd_spawn(w, KD_TAG(position)) : kd_spawn(w, KD_TAG(position), KD_TAG(velocity));
        first = i ? first : e;
    }
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_WITH(position)}});
    assert_int_equal(kd_destroy_query(q), KD_OK);
    assert_int_equal(kd_entity_count(w), 1);
    assert_true(kd_alive(w, keep) && !kd_alive(w, first));
    kd_entity again = kd_spawn(w, KD_TAG(position));
    assert_int_equal(again.generation, 2); /* handles go back and come with a new generation */
    assert_int_equal(kd_query_count(q), 1);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_hold_what_the_prototype_holds),
        cmocka_unit_test(a_clone_stands_beside_the_original),
        cmocka_unit_test(a_copy_below_itself_ends),
        cmocka_unit_test(what_owns_memory_is_not_copied),
        cmocka_unit_test(without_memory_no_copy_is_left),
        cmocka_unit_test(observers_hear_of_copies_and_deaths),
        cmocka_unit_test(a_query_destroys_what_it_matches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
