#include "runtime/bench/sample.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"

enum {
    BUDGET_NS = 400000000, /* measured time after which the least samples are enough */
    SAMPLE_ITEMS = 400000, /* a sample of fewer items repeats its loop */
    MAX_SHARES = 64,
};

_Thread_local volatile double bench_sink;

kd_status bench_open(bench_run *run, const kd_bench_desc *desc, const char *name)
{
    *run = (bench_run){.desc = desc, .name = name, .jobs = kd_jobs_make(desc->threads)};
    if (!run->jobs)
        return kd_fail(KD_NO_MEMORY, "bench: the threads could not be started; ask for fewer with --threads");
    run->threads = kd_jobs_threads(run->jobs);
    return KD_OK;
}

void bench_close(bench_run *run)
{
    kd_jobs_destroy(run->jobs);
}

bool bench_wanted(const bench_run *run, const char *name)
{
    return run->status == KD_OK && (!run->desc->only || strstr(name, run->desc->only));
}

uint32_t bench_size(const bench_run *run, uint32_t fixed)
{
    return run->desc->n && run->desc->n < fixed ? run->desc->n : fixed;
}

uint32_t bench_repeats(uint32_t n)
{
    return n >= SAMPLE_ITEMS ? 1 : SAMPLE_ITEMS / n;
}

void bench_fail(bench_run *run)
{
    if (run->status == KD_OK)
        run->status = kd_fail(KD_NO_MEMORY, "bench: out of memory; choose a smaller size with --n");
}

void *bench_alloc(bench_run *run, size_t count, size_t size)
{
    size_t bytes = (count * size + 63) & ~(size_t)63;
    void *memory = aligned_alloc(64, bytes ? bytes : 64);
    if (memory)
        memset(memory, 0, bytes);
    else
        bench_fail(run);
    return memory;
}

/* ---- samples ---- */

bench bench_begin(bench_run *run, const char *name, uint32_t n, const char *unit, double items)
{
    return (bench){.run = run, .name = name, .unit = unit, .n = n, .threads = 1, .items = items, .count = -1};
}

bool bench_more(const bench *b)
{
    return b->run->status == KD_OK && b->count < BENCH_SAMPLES &&
           (b->count < BENCH_LEAST || b->spent_ns < BUDGET_NS);
}

void bench_start(bench *b)
{
    b->begun_ns = kd_clock_ns();
}

void bench_stop(bench *b)
{
    uint64_t took_ns = kd_clock_ns() - b->begun_ns;
    if (b->count >= 0) {
        b->samples[b->count] = (double)took_ns / b->items;
        b->spent_ns += took_ns;
    }
    b->count++;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(bench *b)
{
    if (b->count <= 0)
        return 0;
    qsort(b->samples, (size_t)b->count, sizeof(double), ascending);
    return b->samples[b->count / 2];
}

void bench_report(bench *b)
{
    if (b->run->status != KD_OK || b->count <= 0)
        return;
    double median = bench_median(b);
    b->run->desc->sink(b->run->desc->user, &(kd_bench_row){.bench = b->run->name,
                                                           .name = b->name,
                                                           .n = b->n,
                                                           .threads = b->threads,
                                                           .unit = b->unit,
                                                           .median = median,
                                                           .min = b->samples[0],
                                                           .max = b->samples[b->count - 1],
                                                           .limit = b->limit});
}

void bench_value(bench_run *run, const char *name, uint32_t n, const char *unit, double value)
{
    bench b = bench_begin(run, name, n, unit, 1);
    b.samples[0] = value;
    b.count = 1;
    bench_report(&b);
}

/* ---- loops without the pool ---- */

typedef struct share {
    bench_share_fn *fn;
    void *user;
    uint32_t begin, end;
    pthread_t thread;
    bool started;
} share;

static void *run_share(void *user)
{
    share *s = user;
    s->fn(s->user, s->begin, s->end);
    return NULL;
}

void bench_split(uint32_t threads, uint32_t count, bench_share_fn *fn, void *user)
{
    share shares[MAX_SHARES];
    threads = threads > MAX_SHARES ? MAX_SHARES : threads;
    for (uint32_t i = 0; i < threads; i++) {
        shares[i] = (share){.fn = fn,
                            .user = user,
                            .begin = (uint32_t)((uint64_t)count * i / threads),
                            .end = (uint32_t)((uint64_t)count * (i + 1) / threads)};
        shares[i].started = i > 0 && pthread_create(&shares[i].thread, NULL, run_share, &shares[i]) == 0;
    }
    for (uint32_t i = 0; i < threads; i++)
        if (!shares[i].started)
            run_share(&shares[i]);
    for (uint32_t i = 0; i < threads; i++)
        if (shares[i].started)
            pthread_join(shares[i].thread, NULL);
}
