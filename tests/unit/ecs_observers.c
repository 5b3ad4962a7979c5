/* Observers: what is told, when, in which order, and what they may do. */

#include "runtime/ecs/observer.h"
#include "tests/unit/ecs_fixture.h"

typedef struct spark {
    uint32_t heat;
} spark;
KD_COMPONENT_DEFINE_FLAGS(spark, "spark", KD_COMPONENT_SPARSE, KD_FIELD(spark, heat, KD_U32, "K", "how hot"));

enum { ALL = KD_ON_ADD | KD_ON_SET | KD_ON_REMOVE | KD_ON_DESTROY };

typedef struct record {
    kd_event event;
    kd_entity entity;
    const kd_component_desc *component;
    int number; /* health.now or spark.heat: in the event for what is gone, else in the world; -1 none */
    bool alive;
} record;
static record records[512];
static uint32_t record_count;

static void note(kd_world *w, const kd_observed *what, void *user)
{
    const void *at = what->value;
    (void)user;
    if (!at)
        at = kd_find_id(w, what->entity, kd_component_ensure(w, what->component));
    assert_true(record_count < 512);
    records[record_count++] =
        (record){what->event, what->entity, what->component,
                 at && what->component->size ? *(const int32_t *)at : -1, kd_alive(w, what->entity)};
}

static kd_world *observed_world(void)
{
    kd_world *w = kd_world_make();
    record_count = 0;
    assert_int_equal(kd_observe(w, &health_desc, ALL, note, NULL), KD_OK);
    assert_int_equal(kd_observe(w, &frozen_desc, ALL, note, NULL), KD_OK);
    assert_int_equal(kd_observe(w, &spark_desc, ALL, note, NULL), KD_OK);
    return w;
}

static void assert_told(uint32_t at, kd_event event, kd_entity e, const kd_component_desc *desc, int number,
                        bool alive)
{
    assert_true(at < record_count);
    assert_int_equal(records[at].event, event);
    assert_entity(records[at].entity, e);
    assert_ptr_equal(records[at].component, desc);
    assert_int_equal(records[at].number, number);
    assert_int_equal(records[at].alive, alive);
}

static void each_change_is_told_once_it_is_complete(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    kd_entity a = kd_spawn(w, KD_TAG(position), KD_VAL(health, {1, 2}));
    assert_int_equal(record_count, 1);
    assert_told(0, KD_ON_ADD, a, &health_desc, 1, true);
    kd_set(w, a, health, {3, 4});
    assert_told(1, KD_ON_SET, a, &health_desc, 3, true);
    kd_set(w, a, spark, {5});
    assert_told(2, KD_ON_ADD, a, &spark_desc, 5, true);
    kd_set(w, a, spark, {6});
    assert_told(3, KD_ON_SET, a, &spark_desc, 6, true);
    kd_add(w, a, frozen);
    assert_told(4, KD_ON_ADD, a, &frozen_desc, -1, true);
    kd_remove(w, a, health);
    assert_told(5, KD_ON_REMOVE, a, &health_desc, 3, true);
    kd_remove(w, a, spark);
    assert_told(6, KD_ON_REMOVE, a, &spark_desc, 6, true);
    kd_set(w, a, velocity, {1, 2, 3});
    kd_find_mut(w, a, position)->x = 1;
    kd_remove(w, a, velocity);
    kd_remove(w, a, velocity);
    assert_int_equal(record_count, 7);
    kd_world_destroy(w);
    assert_int_equal(record_count, 7); /* the end of a world tells nobody */
}

static void death_tells_remove_and_destroy_for_the_whole_subtree(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    kd_entity root = kd_spawn(w, KD_VAL(health, {1, 1}));
    kd_entity leaf = kd_spawn_child(w, root, KD_VAL(spark, {2}));
    assert_told(1, KD_ON_ADD, leaf, &spark_desc, 2, true);
    kd_destroy(w, root);
    assert_int_equal(record_count, 6);
    assert_told(2, KD_ON_REMOVE, leaf, &spark_desc, 2, false);
    assert_told(3, KD_ON_DESTROY, leaf, &spark_desc, 2, false);
    assert_told(4, KD_ON_REMOVE, root, &health_desc, 1, false);
    assert_told(5, KD_ON_DESTROY, root, &health_desc, 1, false);
    kd_world_destroy(w);
}

static void a_merge_tells_after_all_commands(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    kd_entity e[10];
    kd_commands *c = kd_world_commands(w, 0);
    for (int i = 0; i < 10; i++)
        e[i] = kd_spawn(w, KD_TAG(position));
    for (int i = 0; i < 10; i++)
        kd_commands_set(c, e[i], KD_VAL(health, {i, i})); /* one run of neighbouring rows */
    kd_commands_destroy(c, e[3]);
    kd_entity made = kd_commands_spawn(c, (kd_value[]){KD_VAL(health, {77, 0})}, 1);
    assert_int_equal(record_count, 0);
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_int_equal(record_count, 13);
    for (uint32_t i = 0; i < 10; i++)
        assert_told(i, KD_ON_ADD, e[i], &health_desc, i == 3 ? -1 : (int)i,
                    i != 3); /* e[3] is dead already */
    assert_told(10, KD_ON_REMOVE, e[3], &health_desc, 3, false);
    assert_told(11, KD_ON_DESTROY, e[3], &health_desc, 3, false);
    assert_told(12, KD_ON_ADD, kd_entity_resolve(w, made), &health_desc, 77, true);
    kd_world_destroy(w);
}

static void spawn_n_tells_each_row(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    health h[5] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}};
    kd_entity out[5];
    kd_spawn_n(w, 5, (const kd_component_desc *[]){&health_desc}, (const void *[]){h}, 1, out);
    assert_int_equal(record_count, 5);
    for (uint32_t i = 0; i < 5; i++)
        assert_told(i, KD_ON_ADD, out[i], &health_desc, (int)i, true);
    kd_world_destroy(w);
}

/* An observer that changes the world: whoever gets health gets a child, until a depth is reached. */
static void breed(kd_world *w, const kd_observed *what, void *user)
{
    int *most = user;
    if (what->event == KD_ON_ADD && kd_get_depth(w, what->entity) < (uint32_t)*most)
        kd_spawn_child(w, what->entity, KD_TAG(health));
    if (what->event == KD_ON_REMOVE && kd_alive(w, what->entity))
        kd_destroy(w, what->entity);
}

static void observers_may_change_the_world(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    int most = 20;
    kd_observe(w, &health_desc, KD_ON_ADD | KD_ON_REMOVE, breed, &most);
    kd_entity root = kd_spawn(w, KD_TAG(health));
    assert_int_equal(kd_entity_count(w), 21);
    assert_int_equal(record_count, 21);
    kd_remove(w, root, health); /* destroys the rest */
    assert_int_equal(kd_entity_count(w), 0);
    kd_world_destroy(w);
}

static void endless_observers_are_stopped(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    int most = 1000000;
    kd_observe(w, &health_desc, KD_ON_ADD, breed, &most);
    kd_log_set_sink(silent, NULL);
    int errors = kd_log_count(KD_LOG_ERROR);
    kd_spawn(w, KD_TAG(health));
    assert_int_equal(kd_log_count(KD_LOG_ERROR), errors + 1);
    assert_in_range(kd_entity_count(w), 2, KD_MAX_EVENT_ROUNDS + 1);
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(w);
}

static void who_left_is_told_nothing(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    kd_unobserve(w, &health_desc, note, NULL);
    kd_unobserve(w, &position_desc, note, NULL);
    kd_destroy(w, kd_spawn(w, KD_TAG(health)));
    assert_int_equal(record_count, 0);
    kd_spawn(w, KD_TAG(frozen));
    assert_int_equal(record_count, 1);
    kd_world_destroy(w);
}

static void told_values_owned_nothing_any_more(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    record_count = 0;
    owner_releases = 0;
    kd_observe(w, &owner_desc, KD_ON_DESTROY, note, NULL);
    owner o = {owned(3)};
    kd_destroy(w, kd_spawn(w, ((kd_value){&owner_desc, &o})));
    assert_int_equal(record_count, 1);
    assert_int_equal(owner_releases, 1);
    kd_world_destroy(w);
}

static void coming_and_leaving_keeps_nothing(void **state)
{
    (void)state;
    kd_world *w = observed_world();
    size_t bytes = 0;
    for (int i = 0; i < 10000; i++) {
        assert_int_equal(kd_observe(w, &health_desc, ALL, note, &bytes), KD_OK);
        kd_unobserve(w, &health_desc, note, &bytes);
        if (i == 100)
            bytes = kd_world_bytes(w);
    }
    assert_int_equal(kd_world_bytes(w), bytes);
    kd_entity e = kd_spawn(w, KD_VAL(health, {1, 2}));
    assert_int_equal(record_count, 1); /* who was there before still hears */
    assert_told(0, KD_ON_ADD, e, &health_desc, 1, true);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_change_is_told_once_it_is_complete),
        cmocka_unit_test(death_tells_remove_and_destroy_for_the_whole_subtree),
        cmocka_unit_test(a_merge_tells_after_all_commands),
        cmocka_unit_test(spawn_n_tells_each_row),
        cmocka_unit_test(observers_may_change_the_world),
        cmocka_unit_test(endless_observers_are_stopped),
        cmocka_unit_test(who_left_is_told_nothing),
        cmocka_unit_test(told_values_owned_nothing_any_more),
        cmocka_unit_test(coming_and_leaving_keeps_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
