#ifndef KD_BENCH_BENCH_H
#define KD_BENCH_BENCH_H

/* Figures of the ECS and of the jobs on this machine, each beside the bound measured in the same run: plain
 * arrays, memory bandwidth, or the serial work divided by the threads. Every case is sampled 9 to 31 times
 * after a warm-up; times are of the whole loop divided by what it did. */

#include <stdint.h>

#include "runtime/core/status.h"

typedef struct kd_bench_row {
    const char *bench; /* "ecs", "jobs" or "limits" */
    const char *name;  /* of the workload: "iter2" */
    uint32_t n;        /* entities, jobs or elements */
    uint32_t threads;
    const char *unit;        /* "ns/entity" */
    double median, min, max; /* over the samples */
    double limit;            /* in the same unit; 0: none is known */
} kd_bench_row;

typedef void kd_bench_sink(void *user, const kd_bench_row *row);

typedef struct kd_bench_desc {
    uint32_t threads; /* 0: one per processor. Cases for threads run with 1 and with this many */
    uint32_t n;       /* 0: the sizes of the table; else this size alone, and larger fixed sizes cut to it */
    const char *only; /* run the cases whose name contains this; NULL: all */
    kd_bench_sink *sink; /* called for each row as soon as it is there */
    void *user;
} kd_bench_desc;

/** Measure. Errors  KD_NO_MEMORY; rows so far have been handed to the sink */
kd_status kd_bench_ecs(const kd_bench_desc *desc);
kd_status kd_bench_jobs(const kd_bench_desc *desc);
/** Measure triad bandwidth (a = b + s c, 24 bytes an element) from caches and memory, GB/s. */
kd_status kd_bench_limits(const kd_bench_desc *desc);

#endif
