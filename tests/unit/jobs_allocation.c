/* Every allocation of the jobs fails in turn: a pool or a graph is made or not, and what was submitted runs
 * once whether its queue could grow or not. */

#include "tests/allocation_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

#include "runtime/core/log.h"
#include "runtime/jobs/graph.h"

static _Atomic int messages;
static void count_message(void *user, kd_log_level level, const char *text)
{
    (void)user, (void)text;
    messages += level == KD_LOG_ERROR;
}

static int start(void **state)
{
    (void)state;
    kd_log_set_sink(count_message, NULL);
    return 0;
}
static int stop(void **state)
{
    (void)state;
    kd_log_set_sink(NULL, NULL);
    return 0;
}

static void a_pool_is_made_or_not(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads++)
        for (int kind = FAIL_ONCE; kind <= FAIL_ON; kind++) {
            long k = 0, failed;
            do {
                messages = 0;
                allocations_fail_at(k++, (failure_kind)kind);
                kd_jobs *jobs = kd_jobs_make(threads);
                failed = allocations_succeed();
                assert_int_equal(jobs == NULL, failed != 0);
                assert_int_equal(messages, failed != 0);
                kd_jobs_destroy(jobs);
            } while (failed);
            assert_true(k > (long)threads + 3);
        }
}

/* ---- submitting more than any queue has room for ---- */
enum { MANY = 5000 };

typedef struct tally {
    _Atomic uint32_t ran;
} tally;

static void count(void *user, uint32_t worker)
{
    (void)worker;
    atomic_fetch_add(&((tally *)user)->ran, 1);
}

static void count_range(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)worker;
    atomic_fetch_add(&((tally *)user)->ran, end - begin);
}

static void submit_each(kd_jobs *jobs, tally *t, kd_job_counter *done)
{
    for (uint32_t i = 0; i < MANY; i++)
        kd_jobs_run(jobs, count, t, done);
}
static void submit_batch(kd_jobs *jobs, tally *t, kd_job_counter *done)
{
    static void *users[MANY];
    for (uint32_t i = 0; i < MANY; i++)
        users[i] = t;
    kd_jobs_run_n(jobs, count, users, MANY, done);
}
static void submit_first(kd_jobs *jobs, tally *t, kd_job_counter *done)
{
    for (uint32_t i = 0; i < MANY; i++)
        kd_jobs_run_first(jobs, count, t, done);
}
static void rest(void *user, uint32_t worker)
{
    (void)user, (void)worker;
    usleep(1000);
}
static void submit_after(kd_jobs *jobs, tally *t, kd_job_counter *done)
{
    static kd_job_counter before; /* of a job of its own: a submitter without memory may wait for it */
    kd_jobs_run(jobs, rest, NULL, &before);
    for (uint32_t i = 0; i < MANY; i++)
        kd_jobs_run_after(jobs, &before, count, t, done);
    kd_jobs_wait(jobs, &before);
}
static void submit_range(kd_jobs *jobs, tally *t, kd_job_counter *done)
{
    (void)done;
    kd_jobs_parallel_for(jobs, MANY, 1, count_range, t);
}

static void what_is_submitted_runs_once_without_memory(void **state)
{
    static void (*const submits[])(kd_jobs *, tally *, kd_job_counter *) = {
        submit_each, submit_batch, submit_first, submit_after, submit_range};
    (void)state;
    for (size_t s = 0; s < sizeof submits / sizeof *submits; s++)
        for (uint32_t threads = 1; threads <= 2; threads++)
            for (int kind = FAIL_ONCE; kind <= FAIL_ON; kind++) {
                long failed, k = 0;
                do {
                    kd_jobs *jobs = kd_jobs_make(threads);
                    kd_job_counter done = {0};
                    tally t = {0};
                    assert_non_null(jobs);
                    allocations_fail_at(k++, (failure_kind)kind);
                    submits[s](jobs, &t, &done);
                    failed = allocations_succeed();
                    kd_jobs_wait(jobs, &done);
                    assert_int_equal(atomic_load(&t.ran), MANY);
                    kd_jobs_destroy(jobs);
                } while (failed && k < 12);
            }
}

static void a_graph_runs_whole_or_not_at_all(void **state)
{
    enum { NODES = 300 };
    (void)state;
    kd_jobs *jobs = kd_jobs_make(2);
    for (int kind = FAIL_ONCE; kind <= FAIL_ON; kind++) {
        long k = 0, failed;
        do {
            tally t = {0};
            messages = 0;
            allocations_fail_at(k++, (failure_kind)kind);
            kd_job_graph *g = kd_job_graph_make(jobs);
            for (uint32_t i = 0; g && i < NODES; i++) {
                kd_job_node node = kd_job_graph_add(g, count, &t);
                kd_job_graph_place(g, node, i % 10 ? KD_NODE_ANYWHERE : KD_NODE_FIRST);
                if (i)
                    kd_job_graph_edge(g, node / 2, node);
            }
            kd_status status = g ? kd_job_graph_run(g) : KD_NO_MEMORY;
            failed = allocations_succeed();
            assert_true(status == (failed ? KD_NO_MEMORY : KD_OK));
            assert_int_equal(messages != 0, failed != 0);
            assert_int_equal(atomic_load(&t.ran), failed ? 0 : NODES);
            if (g && failed) { /* the same object again, with memory */
                kd_job_graph_clear(g);
                kd_job_graph_add(g, count, &t);
                assert_int_equal(kd_job_graph_run(g), KD_OK);
                assert_int_equal(atomic_load(&t.ran), 1);
            }
            kd_job_graph_destroy(g);
        } while (failed);
        assert_true(k > 5);
    }
    kd_jobs_destroy(jobs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pool_is_made_or_not),
        cmocka_unit_test(what_is_submitted_runs_once_without_memory),
        cmocka_unit_test(a_graph_runs_whole_or_not_at_all),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
