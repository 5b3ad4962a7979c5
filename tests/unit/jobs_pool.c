/* What a pool promises, each case with one thread (inline) and with several. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "runtime/jobs/jobs.h"

static const uint32_t thread_counts[] = {1, 2, 4};
#define FOR_EACH_POOL(jobs)                                                                                  \
    for (size_t pool_index = 0; pool_index < sizeof thread_counts / sizeof thread_counts[0]; pool_index++)   \
        for (kd_jobs *jobs = kd_jobs_make(thread_counts[pool_index]); jobs;                                  \
             kd_jobs_destroy(jobs), jobs = NULL)

static void sleep_us(long us)
{
    nanosleep(&(struct timespec){.tv_nsec = us * 1000}, NULL);
}

static void increment(void *user, uint32_t worker)
{
    (void)worker;
    atomic_fetch_add((atomic_int *)user, 1);
}

static void make_counts_the_calling_thread(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        assert_int_equal(kd_jobs_threads(jobs), thread_counts[pool_index]);
        assert_int_equal(kd_jobs_worker(jobs), 0);
    }
    kd_jobs *all = kd_jobs_make(0);
    assert_true(kd_jobs_threads(all) >= 1);
    kd_jobs_destroy(all);
    kd_jobs_destroy(NULL);
}

static void wait_returns_when_all_jobs_ran_once(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        atomic_int ran = 0;
        kd_job_counter counter = {0};
        for (int i = 0; i < 5000; i++) /* more than a ring holds at first */
            kd_jobs_run(jobs, increment, &ran, &counter);
        kd_jobs_wait(jobs, &counter);
        assert_int_equal(ran, 5000);
        assert_int_equal(counter.pending, 0);
    }
}

static void run_n_runs_each_user_once(void **state)
{
    (void)state;
    enum { N = 3000 };
    static atomic_int ran[N];
    static void *users[N];
    for (int i = 0; i < N; i++)
        users[i] = &ran[i];
    FOR_EACH_POOL(jobs)
    {
        memset(ran, 0, sizeof ran);
        kd_job_counter counter = {0};
        kd_jobs_run_n(jobs, increment, users, N, &counter);
        kd_jobs_run_n(jobs, increment, users, 1, &counter);
        kd_jobs_run_n(jobs, increment, users, 0, &counter);
        kd_jobs_wait(jobs, &counter);
        for (int i = 0; i < N; i++)
            assert_int_equal(ran[i], i == 0 ? 2 : 1);
    }
}

static void one_thread_runs_inline(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(1);
    atomic_int ran = 0;
    kd_jobs_run(jobs, increment, &ran, NULL);
    assert_int_equal(ran, 1);
    kd_jobs_run_lane(jobs, increment, &ran, NULL);
    assert_int_equal(ran, 2);
    kd_jobs_destroy(jobs);
}

typedef struct chain {
    kd_jobs *jobs;
    kd_job_counter counter;
    int left;
} chain;

static void hop(void *user, uint32_t worker)
{
    (void)worker;
    chain *c = user;
    if (--c->left > 0)
        kd_jobs_run(c->jobs, hop, c, &c->counter);
}

/* A million hops would overflow the stack if a job submitted from a job ran inside it. */
static void chain_of_jobs_does_not_nest(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        chain c = {.jobs = jobs, .left = 1000000};
        kd_jobs_run(jobs, hop, &c, &c.counter);
        kd_jobs_wait(jobs, &c.counter);
        assert_int_equal(c.left, 0);
    }
}

typedef struct tree {
    kd_jobs *jobs;
    int depth;
    uint64_t sum;
} tree;

static void grow(void *user, uint32_t worker)
{
    (void)worker;
    tree *t = user;
    t->sum = 1;
    if (t->depth == 0)
        return;
    tree children[2] = {{.jobs = t->jobs, .depth = t->depth - 1}, {.jobs = t->jobs, .depth = t->depth - 1}};
    kd_job_counter counter = {0};
    kd_jobs_run(t->jobs, grow, &children[0], &counter);
    kd_jobs_run(t->jobs, grow, &children[1], &counter);
    kd_jobs_wait(t->jobs, &counter);
    t->sum += children[0].sum + children[1].sum;
}

static void nested_waits_help(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        tree root = {.jobs = jobs, .depth = 12};
        kd_job_counter counter = {0};
        kd_jobs_run(jobs, grow, &root, &counter);
        kd_jobs_wait(jobs, &counter);
        assert_int_equal(root.sum, (1 << 13) - 1); /* nodes of a full binary tree of depth 12 */
    }
}

typedef struct range_check {
    unsigned char *touched;
    uint32_t count, grain, threads;
    atomic_int bad;
} range_check;

static void touch(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    range_check *check = user;
    bool too_many = check->grain && end - begin > check->grain;
    if (begin >= end || end > check->count || too_many || worker >= check->threads)
        atomic_fetch_add(&check->bad, 1);
    for (uint32_t i = begin; i < end; i++)
        check->touched[i]++;
}

static void parallel_for_covers_every_index_once(void **state)
{
    (void)state;
    static const uint32_t counts[] = {0, 1, 2, 7, 100, 4096, 100003}, grains[] = {0, 1, 3, 1000, 200000};
    FOR_EACH_POOL(jobs)
    {
        for (size_t c = 0; c < 7; c++)
            for (size_t g = 0; g < 5; g++) {
                range_check check = {
                    .count = counts[c], .grain = grains[g], .threads = kd_jobs_threads(jobs)};
                check.touched = calloc(counts[c] + 1, 1);
                kd_jobs_parallel_for(jobs, counts[c], grains[g], touch, &check);
                for (uint32_t i = 0; i < counts[c]; i++)
                    assert_int_equal(check.touched[i], 1);
                assert_int_equal(check.bad, 0);
                free(check.touched);
            }
    }
}

typedef struct meeting {
    atomic_int here;
    atomic_int met;
} meeting;

static void meet(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)end;
    (void)worker;
    meeting *m = user;
    if (begin > 1)
        return;
    atomic_fetch_add(&m->here, 1);
    for (int i = 0; i < 20000 && atomic_load(&m->here) < 2; i++)
        sleep_us(100);
    atomic_fetch_add(&m->met, atomic_load(&m->here) == 2);
}

/* Two pieces that each wait for the other: they end only if two threads run them at once. */
static void parallel_for_runs_pieces_at_the_same_time(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(2);
    sleep_us(1000); /* the worker sleeps by now and must be woken */
    meeting m = {0};
    kd_jobs_parallel_for(jobs, 2, 1, meet, &m);
    assert_int_equal(m.met, 2);
    kd_jobs_destroy(jobs);
}

static void meet_job(void *user, uint32_t worker)
{
    meet(user, 0, 1, worker);
}

/* A thief rests when jobs are tiny; that may not outlast them. */
static void long_jobs_run_side_by_side_after_tiny_ones(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(2);
    for (int round = 0; round < 20; round++) {
        atomic_int count = 0;
        meeting m = {0};
        kd_job_counter done = {0};
        for (int i = 0; i < 5000; i++)
            kd_jobs_run(jobs, increment, &count, &done);
        kd_jobs_run(jobs, meet_job, &m, &done);
        kd_jobs_run(jobs, meet_job, &m, &done);
        kd_jobs_wait(jobs, &done);
        assert_int_equal(count, 5000);
        assert_int_equal(m.met, 2);
    }
    kd_jobs_destroy(jobs);
}

typedef struct lane_log {
    kd_jobs *jobs;
    int order[1000];
    int count;
    bool wrong_worker, overlapped, running;
} lane_log;

typedef struct lane_entry {
    lane_log *log;
    int number;
} lane_entry;

static void write_entry(void *user, uint32_t worker)
{
    lane_entry *entry = user;
    lane_log *log = entry->log;
    log->overlapped |= log->running;
    log->running = true;
    log->wrong_worker |= worker != KD_GPU_LANE;
    log->order[log->count++] = entry->number;
    kd_job_counter counter = {0};
    atomic_int ran = 0;
    kd_jobs_run(log->jobs, increment, &ran, &counter);
    kd_jobs_wait(log->jobs, &counter); /* must not begin another lane job in here */
    log->running = false;
}

static lane_entry entries[1000];

static void submit_all_to_lane(void *user, uint32_t worker)
{
    (void)worker;
    lane_log *log = user;
    kd_job_counter counter = {0};
    for (int i = 0; i < 1000; i++) {
        entries[i] = (lane_entry){log, i};
        kd_jobs_run_lane(log->jobs, write_entry, &entries[i], &counter);
    }
    kd_jobs_wait(log->jobs, &counter);
}

static void lane_runs_in_order_on_worker_0_one_at_a_time(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        static lane_log log;
        log = (lane_log){.jobs = jobs};
        kd_job_counter counter = {0};
        kd_jobs_run(jobs, submit_all_to_lane, &log, &counter);
        kd_jobs_wait(jobs, &counter);
        assert_int_equal(log.count, 1000);
        for (int i = 0; i < 1000; i++)
            assert_int_equal(log.order[i], i);
        assert_false(log.wrong_worker);
        assert_false(log.overlapped);
    }
}

static void add_one_lane_job(void *user, uint32_t worker)
{
    (void)worker;
    chain *c = user;
    kd_jobs_run_lane(c->jobs, hop, c, NULL);
}

static void destroy_runs_what_nobody_waited_for(void **state)
{
    (void)state;
    for (size_t p = 0; p < 3; p++) {
        kd_jobs *jobs = kd_jobs_make(thread_counts[p]);
        atomic_int ran = 0;
        for (int i = 0; i < 500; i++)
            kd_jobs_run(jobs, increment, &ran, NULL);
        chain c = {.jobs = jobs, .left = 1};
        kd_jobs_run(jobs, add_one_lane_job, &c, NULL);
        kd_jobs_destroy(jobs);
        assert_int_equal(ran, 500);
        assert_int_equal(c.left, 0);
    }
}

static void record_worker(void *user, uint32_t worker)
{
    chain *c = user;
    c->left = kd_jobs_worker(c->jobs) == worker ? (int)worker : -1;
    sleep_us(100);
}

static void jobs_see_their_own_worker_number(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(3);
    chain seen[64];
    kd_job_counter counter = {0};
    for (int i = 0; i < 64; i++) {
        seen[i] = (chain){.jobs = jobs, .left = -2};
        kd_jobs_run(jobs, record_worker, &seen[i], &counter);
    }
    kd_jobs_wait(jobs, &counter);
    for (int i = 0; i < 64; i++)
        assert_in_range(seen[i].left, 0, 2);
    kd_jobs_destroy(jobs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(make_counts_the_calling_thread),
        cmocka_unit_test(wait_returns_when_all_jobs_ran_once),
        cmocka_unit_test(run_n_runs_each_user_once),
        cmocka_unit_test(one_thread_runs_inline),
        cmocka_unit_test(chain_of_jobs_does_not_nest),
        cmocka_unit_test(nested_waits_help),
        cmocka_unit_test(parallel_for_covers_every_index_once),
        cmocka_unit_test(parallel_for_runs_pieces_at_the_same_time),
        cmocka_unit_test(long_jobs_run_side_by_side_after_tiny_ones),
        cmocka_unit_test(lane_runs_in_order_on_worker_0_one_at_a_time),
        cmocka_unit_test(destroy_runs_what_nobody_waited_for),
        cmocka_unit_test(jobs_see_their_own_worker_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
