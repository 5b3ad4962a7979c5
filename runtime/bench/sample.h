#ifndef KD_BENCH_SAMPLE_H
#define KD_BENCH_SAMPLE_H

/* Samples of one case, and what the cases share.
 *
 *     bench b = bench_begin(run, "iter2", n, "ns/entity", n);
 *     while (bench_more(&b)) {
 *         bench_start(&b);
 *         …
 *         bench_stop(&b);
 *     }
 *     bench_report(&b);
 */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/bench/bench.h"
#include "runtime/jobs/jobs.h"

enum { BENCH_SAMPLES = 31, BENCH_LEAST = 9 };

typedef struct bench_run {
    const kd_bench_desc *desc;
    const char *name; /* of the bench: "ecs" */
    kd_jobs *jobs;    /* threads of them */
    uint32_t threads;
    kd_status status; /* the first failure; cases after it are skipped */
} bench_run;

typedef struct bench {
    bench_run *run;
    const char *name, *unit;
    uint32_t n, threads;
    double items, limit;
    uint64_t begun_ns, spent_ns;
    double samples[BENCH_SAMPLES];
    int count; /* -1: the next one is thrown away */
} bench;

/** Prepare a run: the pool, and room for nothing else. Errors  KD_NO_MEMORY */
kd_status bench_open(bench_run *run, const kd_bench_desc *desc, const char *name);
void bench_close(bench_run *run);

/** Tell whether the case shall run. */
bool bench_wanted(const bench_run *run, const char *name);
/** Cut a fixed size to the size asked for. */
uint32_t bench_size(const bench_run *run, uint32_t fixed);
/** How often a short loop is repeated within a sample, so that the clock's own price vanishes. */
uint32_t bench_repeats(uint32_t n);
/** Allocate zeroed memory, aligned to a cache line; free() it. After a failure the run has failed. */
void *bench_alloc(bench_run *run, size_t count, size_t size);
/** Note that memory ran out. */
void bench_fail(bench_run *run);

/** `items`: what one sample's time is divided by. */
bench bench_begin(bench_run *run, const char *name, uint32_t n, const char *unit, double items);
bool bench_more(const bench *b);
void bench_start(bench *b);
void bench_stop(bench *b);
double bench_median(bench *b);
void bench_report(bench *b);
/** Report a figure that needs no samples. */
void bench_value(bench_run *run, const char *name, uint32_t n, const char *unit, double value);

/** Run fn(user, begin, end) on `threads` threads of equal share, without the pool: the bound for loops. */
typedef void bench_share_fn(void *user, uint32_t begin, uint32_t end);
void bench_split(uint32_t threads, uint32_t count, bench_share_fn *fn, void *user);

static inline uint32_t bench_random(uint32_t *s)
{
    *s ^= *s << 13;
    *s ^= *s >> 17;
    *s ^= *s << 5;
    return *s;
}

/* Where results go that must not be optimised away. */
extern _Thread_local volatile double bench_sink;

#endif
