/* Many threads, tiny jobs, everything mixed: written for the thread sanitizer, and to lose a job or a wake-up
 * if one can be lost. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdatomic.h>
#include <time.h>

#include "runtime/jobs/jobs.h"

#if defined(__SANITIZE_THREAD__)
enum { ROUNDS = 60 };
#else
enum { ROUNDS = 300 };
#endif

typedef struct stress {
    kd_jobs *jobs;
    atomic_uint leaves, lane;
    uint32_t depth, fan;
} stress;

typedef struct node {
    stress *all;
    uint32_t depth;
    uint32_t plain; /* not atomic: written by the job, read after the wait */
} node;

static void lane_job(void *user, uint32_t worker)
{
    stress *all = user;
    if (worker == KD_GPU_LANE)
        atomic_fetch_add_explicit(&all->lane, 1, memory_order_relaxed);
}

static void range_job(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)worker;
    uint32_t *values = user;
    for (uint32_t i = begin; i < end; i++)
        values[i] = i * 3;
}

static void node_job(void *user, uint32_t worker)
{
    (void)worker;
    node *n = user;
    stress *all = n->all;
    n->plain = n->depth + 1;
    if (n->depth == 0) {
        atomic_fetch_add_explicit(&all->leaves, 1, memory_order_relaxed);
        return;
    }
    node children[4];
    void *users[4];
    for (int i = 0; i < 4; i++) {
        children[i] = (node){all, n->depth - 1, 0};
        users[i] = &children[i];
    }
    kd_job_counter counter = {0};
    kd_jobs_run_n(all->jobs, node_job, users, 3, &counter);
    kd_jobs_run(all->jobs, node_job, users[3], &counter);
    kd_jobs_run_lane(all->jobs, lane_job, all, n->depth & 1 ? &counter : NULL);
    uint32_t values[50] = {0};
    kd_jobs_parallel_for(all->jobs, 50, 4, range_job, values);
    kd_jobs_wait(all->jobs, &counter);
    for (uint32_t i = 0; i < 50; i++)
        if (values[i] != i * 3)
            n->plain = 0;
    for (int i = 0; i < 4; i++)
        if (children[i].plain != n->depth)
            n->plain = 0;
}

/* A tree of fan 4 and depth 4 has 256 leaves and 85 inner nodes, each of which sends one job to the lane. */
static void trees_of_jobs_lose_nothing(void **state)
{
    (void)state;
    static const uint32_t thread_counts[] = {1, 2, 3, 8};
    for (int t = 0; t < 4; t++) {
        stress all = {.jobs = kd_jobs_make(thread_counts[t])};
        for (unsigned round = 0; round < ROUNDS / 6; round++) {
            node root = {&all, 4, 0};
            kd_job_counter counter = {0};
            kd_jobs_run(all.jobs, node_job, &root, &counter);
            kd_jobs_wait(all.jobs, &counter);
            assert_int_equal(root.plain, 5);
            assert_int_equal(all.leaves, 256 * (round + 1));
        }
        kd_jobs_destroy(all.jobs);
        assert_int_equal(all.lane, 85 * (ROUNDS / 6));
    }
}

static void empty_job(void *user, uint32_t worker)
{
    (void)worker;
    ++*(uint32_t *)user;
}

/* Pauses of varying length round the moment at which workers fall asleep: a lost wake-up would hang here. */
static void workers_wake_up_however_long_they_slept(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(4);
    for (int round = 0; round < ROUNDS; round++) {
        uint32_t values[3] = {0};
        void *users[3] = {&values[0], &values[1], &values[2]};
        kd_job_counter counter = {0};
        kd_jobs_run_n(jobs, empty_job, users, 3, &counter);
        kd_jobs_wait(jobs, &counter);
        assert_int_equal(values[0] + values[1] + values[2], 3);
        nanosleep(&(struct timespec){.tv_nsec = round % 50 * 1000}, NULL);
    }
    kd_jobs_destroy(jobs);
}

static void slow_job(void *user, uint32_t worker)
{
    (void)worker;
    nanosleep(&(struct timespec){.tv_nsec = 200000}, NULL);
    ++*(uint32_t *)user;
}

/* Worker 0 finds nothing to help with and sleeps; the end of the last job must wake it. */
static void waiter_sleeps_until_the_counter_is_zero(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(3);
    for (int round = 0; round < ROUNDS; round++) {
        uint32_t values[2] = {0};
        kd_job_counter counter = {0};
        kd_jobs_run(jobs, slow_job, &values[0], &counter);
        kd_jobs_run(jobs, slow_job, &values[1], &counter);
        kd_jobs_wait(jobs, &counter);
        assert_int_equal(values[0] + values[1], 2);
    }
    kd_jobs_destroy(jobs);
}

static void pools_come_and_go(void **state)
{
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        kd_jobs *jobs = kd_jobs_make(3);
        uint32_t value = 0;
        if (round & 1)
            kd_jobs_run(jobs, empty_job, &value, NULL);
        kd_jobs_destroy(jobs);
        assert_int_equal(value, round & 1);
    }
}

static void two_pools_of_one_thread_do_not_mix(void **state)
{
    (void)state;
    kd_jobs *a = kd_jobs_make(2), *b = kd_jobs_make(2);
    uint32_t values[200] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        kd_jobs_parallel_for(round & 1 ? a : b, 200, 7, range_job, values);
        assert_int_equal(values[199], 597);
        values[199] = 0;
    }
    kd_jobs_destroy(a);
    kd_jobs_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_of_jobs_lose_nothing),
        cmocka_unit_test(workers_wake_up_however_long_they_slept),
        cmocka_unit_test(waiter_sleeps_until_the_counter_is_zero),
        cmocka_unit_test(pools_come_and_go),
        cmocka_unit_test(two_pools_of_one_thread_do_not_mix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
