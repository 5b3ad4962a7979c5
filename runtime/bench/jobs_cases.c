/* Jobs: what one costs to start, to join, to follow another, and what a second thread brings. */
#include <stdlib.h>
#include <string.h>

#include "runtime/bench/sample.h"
#include "runtime/jobs/graph.h"

enum {
    JOBS = 10000,
    FLOATS = 10000000,
    FLOAT_GRAIN = 65536,
    GRAPH = 1000,
    MAX_BEFORE = 3,   /* predecessors of a node of the random graph */
    WORK_STEPS = 200, /* about 0.42 us */
};

static void empty(void *user, uint32_t worker)
{
    (void)user;
    (void)worker;
}

static void empty_range(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)user;
    (void)begin;
    (void)end;
    (void)worker;
}

/* A chain of dependent operations that no compiler can shorten: it begins and ends in a volatile. */
static void work(void *user, uint32_t worker)
{
    double x;
    (void)user;
    (void)worker;
    bench_sink = 1;
    x = bench_sink;
    for (int i = 0; i < WORK_STEPS; i++)
        x = x * 0.999 + 1e-3;
    bench_sink = x;
}

static double serial_work(bench_run *run)
{
    bench b = bench_begin(run, "serial", JOBS, "ns/job", JOBS);
    kd_job_fn *volatile fn = work;
    while (bench_more(&b)) {
        bench_start(&b);
        for (int i = 0; i < JOBS; i++)
            fn(NULL, 0);
        bench_stop(&b);
    }
    return bench_median(&b);
}

/* ---- starting and joining ---- */

static void bench_jobs_one_by_one(bench_run *run, kd_jobs *jobs, const char *name, kd_job_fn *fn,
                                  double limit)
{
    uint32_t n = bench_size(run, JOBS);
    if (!bench_wanted(run, name))
        return;
    bench b = bench_begin(run, name, n, "ns/job", n);
    b.threads = kd_jobs_threads(jobs);
    b.limit = limit;
    while (bench_more(&b)) {
        kd_job_counter counter = {0};
        bench_start(&b);
        for (uint32_t i = 0; i < n; i++)
            kd_jobs_run(jobs, fn, NULL, &counter);
        kd_jobs_wait(jobs, &counter);
        bench_stop(&b);
    }
    bench_report(&b);
}

static void bench_jobs_batch(bench_run *run, kd_jobs *jobs, const char *name, kd_job_fn *fn, double limit)
{
    uint32_t n = bench_size(run, JOBS);
    void **users = bench_wanted(run, name) ? bench_alloc(run, n, sizeof *users) : NULL;
    if (!users)
        return;
    bench b = bench_begin(run, name, n, "ns/job", n);
    b.threads = kd_jobs_threads(jobs);
    b.limit = limit;
    while (bench_more(&b)) {
        kd_job_counter counter = {0};
        bench_start(&b);
        kd_jobs_run_n(jobs, fn, users, n, &counter);
        kd_jobs_wait(jobs, &counter);
        bench_stop(&b);
    }
    bench_report(&b);
    free(users);
}

static void bench_loops(bench_run *run, kd_jobs *jobs, const char *name, uint32_t count, uint32_t calls,
                        const char *unit, double items)
{
    if (!bench_wanted(run, name))
        return;
    bench b = bench_begin(run, name, count, unit, items);
    b.threads = kd_jobs_threads(jobs);
    while (bench_more(&b)) {
        bench_start(&b);
        for (uint32_t i = 0; i < calls; i++)
            kd_jobs_parallel_for(jobs, count, 1, empty_range, NULL);
        bench_stop(&b);
    }
    bench_report(&b);
}

/* ---- saxpy ---- */

typedef struct vectors {
    float *x, *y;
} vectors;

static void saxpy_share(void *user, uint32_t begin, uint32_t end)
{
    const vectors *v = user;
    const float *x = v->x;
    float *restrict y = v->y;
    for (uint32_t i = begin; i < end; i++)
        y[i] += 0.5f * x[i];
}

static void saxpy(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)worker;
    saxpy_share(user, begin, end);
}

static double plain_saxpy(bench_run *run, uint32_t threads, uint32_t n, vectors *v)
{
    bench b = bench_begin(run, "plain", n, "ns/float", n);
    while (bench_more(&b)) {
        bench_start(&b);
        bench_split(threads, n, saxpy_share, v);
        bench_stop(&b);
    }
    return bench_median(&b);
}

static void bench_saxpy(bench_run *run, kd_jobs *jobs)
{
    uint32_t n = bench_size(run, FLOATS);
    if (!bench_wanted(run, "saxpy10M"))
        return;
    vectors v = {bench_alloc(run, n, sizeof(float)), bench_alloc(run, n, sizeof(float))};
    bench b = bench_begin(run, "saxpy10M", n, "ns/float", n);
    b.threads = kd_jobs_threads(jobs);
    if (v.x && v.y)
        b.limit = plain_saxpy(run, b.threads, n, &v);
    while (bench_more(&b)) {
        bench_start(&b);
        kd_jobs_parallel_for(jobs, n, FLOAT_GRAIN, saxpy, &v);
        bench_stop(&b);
    }
    bench_report(&b);
    free(v.x);
    free(v.y);
}

/* ---- graphs ---- */

static void build_chain(kd_job_graph *g, uint32_t n, kd_job_fn *fn)
{
    for (uint32_t i = 0; i < n; i++) {
        kd_job_node node = kd_job_graph_add(g, fn, NULL);
        if (i > 0)
            kd_job_graph_edge(g, node - 1, node);
    }
}

/* Up to three different predecessors a node; 1486 edges for 1000 nodes. */
static void build_random(kd_job_graph *g, uint32_t n, kd_job_fn *fn)
{
    uint32_t s = 7;
    kd_job_graph_add(g, fn, NULL);
    for (uint32_t i = 1; i < n; i++) {
        uint32_t before[MAX_BEFORE], count = 0, draws = bench_random(&s) % (MAX_BEFORE + 1);
        kd_job_node node = kd_job_graph_add(g, fn, NULL);
        for (uint32_t k = 0; k < draws; k++) {
            uint32_t drawn = bench_random(&s) % i;
            bool known = false;
            for (uint32_t j = 0; j < count; j++)
                known = known || before[j] == drawn;
            if (!known) {
                before[count++] = drawn;
                kd_job_graph_edge(g, drawn, node);
            }
        }
    }
}

typedef void build_fn(kd_job_graph *g, uint32_t n, kd_job_fn *fn);

static void bench_graph(bench_run *run, kd_jobs *jobs, const char *name, build_fn *build, kd_job_fn *fn,
                        bool rebuild, double limit)
{
    uint32_t n = bench_size(run, GRAPH);
    kd_job_graph *g = bench_wanted(run, name) ? kd_job_graph_make(jobs) : NULL;
    if (!g)
        return;
    bench b = bench_begin(run, name, n, "ns/node", n);
    b.threads = kd_jobs_threads(jobs);
    b.limit = limit;
    build(g, n, fn);
    while (bench_more(&b)) {
        bench_start(&b);
        if (rebuild) {
            kd_job_graph_clear(g);
            build(g, n, fn);
        }
        kd_status status = kd_job_graph_run(g);
        bench_stop(&b);
        if (status != KD_OK)
            run->status = status;
    }
    bench_report(&b);
    kd_job_graph_destroy(g);
}

static void bench_with(bench_run *run, kd_jobs *jobs, double work_ns)
{
    uint32_t n = bench_size(run, JOBS);
    double share_ns = work_ns / kd_jobs_threads(jobs);
    bench_jobs_one_by_one(run, jobs, "empty_job", empty, 0);
    bench_jobs_batch(run, jobs, "empty_job_batch", empty, 0);
    bench_jobs_one_by_one(run, jobs, "work_job", work, share_ns);
    bench_jobs_batch(run, jobs, "work_job_batch", work, share_ns);
    bench_loops(run, jobs, "forkjoin_latency", 2, 1000, "ns/call", 1000);
    bench_loops(run, jobs, "parfor_empty_grain1", n, 1, "ns/index", n);
    bench_saxpy(run, jobs);
    bench_graph(run, jobs, "chain1000", build_chain, empty, false, 0);
    bench_graph(run, jobs, "dag1000", build_random, empty, false, 0);
    bench_graph(run, jobs, "dag1000_rebuilt", build_random, empty, true, 0);
    bench_graph(run, jobs, "dag1000_work", build_random, work, false, share_ns);
}

kd_status kd_bench_jobs(const kd_bench_desc *desc)
{
    bench_run run;
    kd_status status = bench_open(&run, desc, "jobs");
    if (status != KD_OK)
        return status;
    kd_jobs *alone = kd_jobs_make(1);
    double work_ns = serial_work(&run);
    if (!alone)
        bench_fail(&run);
    else
        bench_with(&run, alone, work_ns);
    if (run.threads > 1)
        bench_with(&run, run.jobs, work_ns);
    kd_jobs_destroy(alone);
    bench_close(&run);
    return run.status;
}
