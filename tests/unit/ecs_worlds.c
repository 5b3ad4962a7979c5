/* Many worlds: ten thousand one after another leave nothing behind, two at a time never meet, and one on each
 * of several threads is nobody else's business. */

#include <malloc.h>
#include <pthread.h>

#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/system.h"
#include "runtime/ecs/validate.h"
#include "runtime/jobs/jobs.h"
#include "tests/unit/ecs_fixture.h"

typedef struct charge {
    float amount;
} charge;
KD_COMPONENT_DEFINE_FLAGS(charge, "charge", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(charge, amount, KD_F32, "C", "how much"));

static void hear(kd_world *w, const kd_observed *what, void *user)
{
    (void)w, (void)what;
    ++*(int *)user;
}

/* A little of everything; returns the checksum. */
static uint64_t fill(kd_world *w, uint32_t seed)
{
    int heard = 0;
    kd_entity e[20];
    kd_observe(w, &health_desc, KD_ON_ADD | KD_ON_REMOVE, hear, &heard);
    kd_query_make(
        w, &(kd_query_desc){.terms = {KD_READ(position), KD_WITHOUT(frozen)}, .name = "left to the world"});
    for (uint32_t i = 0; i < 20; i++) {
        kd_value values[] = {KD_VAL(position, {(float)(i * seed), 1, 2}), KD_TAG(health),
                             KD_VAL(charge, {1})};
        e[i] = i % 4 ? kd_spawn_child_values(w, e[i - 1], values, 1 + i % 3)
                     : kd_spawn_values(w, values, 1 + i % 3);
        assert_true(kd_alive(w, e[i]));
    }
    kd_set_name(w, e[3], "one of them");
    kd_set(w, e[5], owner, {owned((int)seed)});
    kd_disable(w, e[2], charge);
    kd_singleton(w, health)->now = (int32_t)seed;
    assert_true(kd_clone(w, e[8]).generation);
    kd_commands_destroy(kd_world_commands(w, 2), e[4]);
    assert_int_equal(kd_world_merge(w), KD_OK);
    kd_commands_spawn(kd_world_commands(w, 1), (kd_value[]){KD_VAL(owner, {owned(2)})}, 1); /* never merged */
    assert_true(heard > 5);
    kd_unobserve(w, &health_desc, hear, &heard);
    return kd_world_checksum(w);
}

static uint64_t fill_and_destroy(uint32_t seed)
{
    kd_world *w = kd_world_make();
    assert_non_null(w);
    uint64_t checksum = fill(w, seed);
    kd_world_destroy(w);
    return checksum;
}

static void ten_thousand_worlds_leave_nothing(void **state)
{
    enum { WORLDS = 10000 };
    (void)state;
    uint64_t first = fill_and_destroy(7);
    struct mallinfo2 before = mallinfo2(); /* zeros under a sanitizer, whose leak checker looks instead */
    owner_releases = 0;
    for (uint32_t i = 0; i < WORLDS; i++)
        assert_true(fill_and_destroy(7) == first); /* a world knows nothing of those before it */
    assert_int_equal(owner_releases, 2 * WORLDS);
    struct mallinfo2 after = mallinfo2();
    assert_in_range(after.uordblks, 0, before.uordblks + 8 * WORLDS); /* less than a block a world */
    assert_int_equal(after.hblks, before.hblks);
}

/* Two worlds register in other orders, take turns, and give the results that each gives alone. */
static void two_worlds_never_meet(void **state)
{
    (void)state;
    uint64_t alone[2] = {fill_and_destroy(3), fill_and_destroy(5)};
    kd_world *a = kd_world_make(), *b = kd_world_make();
    kd_component_id position_a = KD_ID(a, position), velocity_b = KD_ID(b, velocity);
    assert_int_equal(position_a, velocity_b); /* the first of each */
    assert_int_equal(kd_component_find(b, "position"), 0);
    assert_true(fill(a, 3) == alone[0] && fill(b, 5) == alone[1]);
    kd_entity of_a = kd_spawn(a, KD_VAL(velocity, {1, 0, 0})),
              of_b = kd_spawn(b, KD_VAL(position, {2, 0, 0}));
    for (int i = 0; i < 100; i++) {
        assert_int_equal(kd_find(a, of_a, velocity)->x, 1);
        assert_int_equal(kd_find(b, of_b, position)->x, 2);
        assert_true(!kd_has(a, of_a, position) && !kd_has(b, of_b, velocity));
    }
    kd_world_destroy(a);
    assert_int_equal(kd_find(b, of_b, position)->x, 2);
    assert_int_equal(kd_world_validate(b), KD_OK);
    kd_world_destroy(b);
}

/* Ids belong to a world. One that another world gave is a mistake; it finds nothing and breaks nothing. */
static void ids_of_another_world_find_nothing(void **state)
{
    (void)state;
    kd_world *large = kd_world_make(), *small = kd_world_make();
    (void)KD_ID(large, position), (void)KD_ID(large, velocity), (void)KD_ID(large, health);
    kd_component_id foreign = KD_ID(large, charge);
    kd_entity e = kd_spawn(small, KD_TAG(position)), bare = kd_spawn_values(small, NULL, 0);
    assert_true(kd_alive(small, bare));
    assert_null(kd_find_id(small, e, foreign));
    assert_null(kd_find_mut_id(small, e, foreign));
    assert_int_equal(kd_remove_id(small, e, foreign), KD_OK);
    assert_int_equal(kd_enable_id(small, e, foreign, false), KD_NOT_FOUND);
    assert_false(kd_is_enabled_id(small, e, foreign));
    assert_null(kd_component_info(small, foreign));
    assert_null(kd_singleton_find(small, foreign));
    for (kd_component_id id = 600; id < 1u << 31; id *= 99) { /* nobody's */
        assert_int_equal(kd_remove_id(small, e, id), KD_OK);
        assert_false(kd_is_enabled_id(small, e, id));
        assert_int_equal(kd_pair_count_id(small, id), 0);
        assert_int_equal(kd_targets_id(small, e, id).count, 0);
        assert_null(kd_pair_find_mut_id(small, e, id, e));
    }
    assert_int_equal(kd_world_validate(small), KD_OK);
    kd_world_destroy(large);
    kd_world_destroy(small);
}

/* ---- a world for each thread ---- */
typedef struct owner_thread {
    pthread_t thread;
    uint32_t rounds;
    uint64_t checksum;
} owner_thread;

static void push(kd_iter *rows, kd_commands *commands, void *user)
{
    position *p = KD_COLUMN_MUT(rows, position, 0);
    (void)user;
    for (uint32_t i = 0; i < rows->count; i++) {
        p[i].x += 0.5f;
        if (p[i].x > 30)
            kd_commands_destroy(commands, rows->entities[i]);
    }
}

static void push_system(kd_system_context *context)
{
    kd_query_parallel(context->user, context->jobs, context->command_key, push, NULL);
}

static uint64_t run_world(uint32_t rounds)
{
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(2);
    fill(w, 1);
    kd_world_merge(w);
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(position)}});
    kd_schedule *s = kd_schedule_make(w, jobs, NULL);
    kd_schedule_add(s, &(kd_system_desc){.name = "push",
                                         .phase = KD_PHASE_ANIMATE,
                                         .components = {KD_CHANGES(position)},
                                         .run = push_system,
                                         .user = q});
    for (uint32_t i = 0; i < rounds; i++) {
        for (int k = 0; k < 20; k++)
            kd_spawn(w, KD_VAL(position, {(float)(k + (int)i % 3), 0, 0}));
        assert_int_equal(kd_schedule_run(s), KD_OK);
    }
    assert_int_equal(kd_world_validate(w), KD_OK);
    uint64_t checksum = kd_world_checksum(w);
    kd_schedule_destroy(s);
    kd_world_destroy(w);
    kd_jobs_destroy(jobs);
    return checksum;
}

static void *run_owner(void *user)
{
    owner_thread *t = user;
    t->checksum = run_world(t->rounds);
    return NULL;
}

static void each_thread_may_have_a_world_of_its_own(void **state)
{
    enum { THREADS = 4, ROUNDS = 200 };
    owner_thread threads[THREADS] = {{0}};
    (void)state;
    uint64_t alone = run_world(ROUNDS);
    for (int i = 0; i < THREADS; i++) {
        threads[i].rounds = ROUNDS;
        assert_int_equal(pthread_create(&threads[i].thread, NULL, run_owner, &threads[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(threads[i].thread, NULL);
        assert_true(threads[i].checksum == alone);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ten_thousand_worlds_leave_nothing),
        cmocka_unit_test(two_worlds_never_meet),
        cmocka_unit_test(ids_of_another_world_find_nothing),
        cmocka_unit_test(each_thread_may_have_a_world_of_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
