/* Queries shared among workers: every row once, and the same world afterwards at any thread count. */

#include <sched.h>

#include "runtime/jobs/jobs.h"
#include "tests/unit/ecs_fixture.h"

typedef struct spark {
    uint32_t heat;
} spark;
KD_COMPONENT_DEFINE_FLAGS(spark, "spark", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(spark, heat, KD_U32, "K", "how hot"));

/* n entities in several tables, some of them empty, with sparse values here and there. */
static kd_world *mixed_world(uint32_t n)
{
    kd_world *w = kd_world_make();
    assert_non_null(w);
    kd_entity last = KD_NO_ENTITY;
    kd_destroy(w, kd_spawn(w, KD_TAG(health), KD_TAG(padded)));
    for (uint32_t i = 0; i < n; i++) {
        kd_value values[4] = {KD_VAL(health, {(int)i, 0})};
        uint32_t count = 1;
        if (i % 3 == 0)
            values[count++] = KD_TAG(position);
        if (i % 7 == 0)
            values[count++] = KD_TAG(frozen);
        kd_entity e =
            i % 5 == 4 ? kd_spawn_child_values(w, last, values, count) : kd_spawn_values(w, values, count);
        if (i % 4 == 0)
            kd_set(w, e, spark, {i});
        if (i % 16 == 0)
            kd_disable(w, e, spark);
        last = e;
    }
    return w;
}

static void visit_once(kd_iter *rows, kd_commands *c, void *user)
{
    health *h = KD_COLUMN_MUT(rows, health, 0);
    (void)c, (void)user;
    for (uint32_t i = 0; i < rows->count; i++)
        h[i].most++;
}

static void every_row_is_visited_once(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {0, 1, 15, 16, 17, 1000, 70000};
    for (uint32_t threads = 1; threads <= 4; threads += 3) {
        kd_jobs *jobs = kd_jobs_make(threads);
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            kd_world *w = mixed_world(sizes[s]);
            kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(health)}});
            uint64_t version = kd_world_version(w);
            uint32_t rows = 0;
            assert_int_equal(kd_query_parallel(q, jobs, 0, visit_once, NULL), KD_OK);
            kd_iter it = kd_query_iter(q);
            it.changed_since = version; /* and all of them count as changed */
            for (; kd_iter_next(&it); rows += it.count)
                for (uint32_t i = 0; i < it.count; i++)
                    assert_int_equal(KD_COLUMN(&it, health, 0)[i].most, 1);
            assert_int_equal(rows, sizes[s]);
            kd_world_destroy(w);
        }
        kd_jobs_destroy(jobs);
    }
}

/* Some work, so that the loop is worth sharing; then commands of every kind, row by row. */
static void change_structure(kd_iter *rows, kd_commands *c, void *user)
{
    const health *h = KD_COLUMN(rows, health, 0);
    (void)user;
    for (uint32_t i = 0; i < rows->count; i++) {
        uint64_t random = (uint64_t)h[i].now * 77 + 1;
        for (int k = 0; k < 200; k++)
            random_u32(&random);
        kd_entity e = rows->entities[i];
        switch (random_u32(&random) % 6) {
        case 0: kd_commands_destroy(c, e); break;
        case 1: {
            kd_entity made = kd_commands_spawn(c, (kd_value[]){KD_VAL(bond, {e, (uint32_t)h[i].now})}, 1);
            kd_commands_set_parent(c, made, e);
            break;
        }
        case 2: kd_commands_set(c, e, KD_VAL(velocity, {1, 2, (float)h[i].now})); break;
        case 3: kd_commands_remove(c, e, &frozen_desc); break;
        case 4: kd_commands_enable(c, e, &spark_desc, random & 1); break;
        default: break;
        }
    }
}

static uint64_t changed_world(uint32_t threads, const kd_query_desc *desc)
{
    kd_jobs *jobs = threads ? kd_jobs_make(threads) : NULL;
    kd_world *w = mixed_world(9000);
    kd_query *q = kd_query_make(w, desc);
    for (int round = 0; round < 3; round++) {
        kd_commands_key(kd_world_commands(w, 0), 3);
        assert_int_equal(kd_query_parallel(q, jobs, 1000, change_structure, NULL), KD_OK);
        kd_commands_spawn(kd_world_commands(w, 0), NULL, 0); /* its key is still 3: comes first */
        assert_int_equal(kd_world_merge(w), KD_OK);
    }
    uint64_t checksum = kd_world_checksum(w);
    kd_world_destroy(w);
    kd_jobs_destroy(jobs);
    return checksum;
}

static void commands_give_the_same_world_at_any_thread_count(void **state)
{
    (void)state;
    static const kd_query_desc descs[] = {
        {.terms = {KD_READ(health)}},
        {.terms = {KD_READ(health), KD_READ(spark)}, .by_depth = true},
        {.terms = {KD_READ(health), KD_WITHOUT(spark), KD_OPTIONAL(position)}},
    };
    for (size_t i = 0; i < sizeof descs / sizeof *descs; i++) {
        uint64_t alone = changed_world(0, &descs[i]);
        for (uint32_t threads = 1; threads <= 4; threads++)
            assert_true(changed_world(threads, &descs[i]) == alone);
    }
}

/* Commands before, between and behind two loops under the caller's own key: each as in the text of the
 * program, wherever the rows were cut. */
static uint64_t looped_twice(uint32_t threads)
{
    kd_jobs *jobs = threads ? kd_jobs_make(threads) : NULL;
    kd_world *w = mixed_world(9000);
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(health)}});
    kd_commands *own = kd_world_commands(w, 0);
    for (uint32_t loop = 0; loop < 2; loop++) {
        kd_commands_spawn(own, (kd_value[]){KD_VAL(bond, {KD_NO_ENTITY, loop})}, 1);
        assert_int_equal(kd_query_parallel(q, jobs, 0, change_structure, NULL), KD_OK);
    }
    kd_commands_spawn(own, (kd_value[]){KD_VAL(bond, {KD_NO_ENTITY, 2})}, 1);
    assert_int_equal(kd_world_merge(w), KD_OK);
    uint64_t checksum = kd_world_checksum(w);
    kd_world_destroy(w);
    kd_jobs_destroy(jobs);
    return checksum;
}

static void what_is_recorded_behind_a_loop_is_merged_behind_its_rows(void **state)
{
    (void)state;
    uint64_t alone = looped_twice(0);
    for (uint32_t threads = 1; threads <= 4; threads++)
        assert_true(looped_twice(threads) == alone);
}

typedef struct wide_kind {
    float value;
} wide_kind;

static void count_rows(kd_iter *rows, kd_commands *c, void *user)
{
    (void)c;
    __atomic_fetch_add((uint32_t *)user, rows->count, __ATOMIC_RELAXED);
}

static void more_tables_than_usual_are_fine(void **state)
{
    (void)state;
    static const char *const names[9] = {"k0", "k1", "k2", "k3", "k4", "k5", "k6", "k7", "k8"};
    kd_component_desc kinds[9];
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(2);
    uint32_t rows = 0;
    for (int k = 0; k < 9; k++)
        kinds[k] =
            (kd_component_desc){.name = names[k], .size = sizeof(wide_kind), .align = _Alignof(wide_kind)};
    for (uint32_t set = 0; set < 512; set++) {
        kd_value values[10] = {KD_TAG(health)};
        uint32_t count = 1;
        for (uint32_t k = 0; k < 9; k++)
            if (set >> k & 1)
                values[count++] = (kd_value){&kinds[k], NULL};
        kd_spawn_values(w, values, count);
    }
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(health)}});
    assert_int_equal(kd_query_parallel(q, jobs, 0, count_rows, &rows), KD_OK);
    assert_int_equal(rows, 512);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
}

typedef struct lone_loop {
    kd_world *world;
    kd_query *query;
    uint32_t worker;
    _Atomic uint32_t wrong, ended;
} lone_loop;

static void compare_buffer(kd_iter *rows, kd_commands *c, void *user)
{
    lone_loop *loop = user;
    (void)rows;
    loop->wrong += c != kd_world_commands(loop->world, loop->worker);
}

static void loop_without_pool(void *user, uint32_t worker)
{
    lone_loop *loop = user;
    loop->worker = worker;
    kd_query_parallel(loop->query, NULL, 0, compare_buffer, loop);
    loop->ended = 1;
}

/* The buffer of worker 0 may be in use by worker 0 meanwhile. */
static void a_loop_without_a_pool_records_for_the_worker_that_runs_it(void **state)
{
    (void)state;
    kd_world *w = mixed_world(100);
    kd_jobs *jobs = kd_jobs_make(2);
    lone_loop loop = {.world = w, .query = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(health)}})};
    kd_jobs_run(jobs, loop_without_pool, &loop, NULL);
    while (!loop.ended) /* this thread, worker 0, does not help: the other one runs it */
        sched_yield();
    assert_int_equal(loop.worker, 1);
    assert_int_equal(loop.wrong, 0);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_row_is_visited_once),
        cmocka_unit_test(commands_give_the_same_world_at_any_thread_count),
        cmocka_unit_test(what_is_recorded_behind_a_loop_is_merged_behind_its_rows),
        cmocka_unit_test(more_tables_than_usual_are_fine),
        cmocka_unit_test(a_loop_without_a_pool_records_for_the_worker_that_runs_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
