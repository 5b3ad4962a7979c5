/* Bandwidth: the triad of McCalpin's STREAM, counting 24 bytes an element. */
#include <stdlib.h>

#include "runtime/bench/sample.h"

typedef struct triad_arrays {
    double *a, *b, *c;
} triad_arrays;

static void triad(void *user, uint32_t begin, uint32_t end)
{
    triad_arrays *t = user;
    double *restrict a = t->a;
    const double *b = t->b, *c = t->c;
    for (uint32_t i = begin; i < end; i++)
        a[i] = b[i] + 3.0 * c[i];
}

static void measure(bench_run *run, const char *name, uint32_t n, uint32_t threads, triad_arrays *t)
{
    uint32_t inner = threads == 1 ? bench_repeats(n) * 10 : 1;
    bench b = bench_begin(run, name, n, "GB/s", 1);
    b.threads = threads;
    while (bench_more(&b)) {
        bench_start(&b);
        for (uint32_t i = 0; i < inner; i++)
            bench_split(threads, n, triad, t);
        bench_stop(&b);
        if (b.count > 0) /* ns to GB/s */
            b.samples[b.count - 1] = 24.0 * n * inner / b.samples[b.count - 1];
        bench_sink = t->a[n - 1];
    }
    bench_report(&b);
}

kd_status kd_bench_limits(const kd_bench_desc *desc)
{
    static const struct {
        const char *name;
        uint32_t n;
        bool threads; /* starting a thread costs more than the small ones take */
    } rows[] = {{"triad_L1", 2000, false},
                {"triad_L2", 60000, false},
                {"triad_L3_24MB", 1000000, true},
                {"triad_DRAM_240MB", 10000000, true}};
    bench_run run;
    kd_status status = bench_open(&run, desc, "limits");
    if (status != KD_OK)
        return status;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        uint32_t n = bench_size(&run, rows[i].n);
        if (!bench_wanted(&run, rows[i].name))
            continue;
        triad_arrays t = {bench_alloc(&run, n, 8), bench_alloc(&run, n, 8), bench_alloc(&run, n, 8)};
        if (run.status == KD_OK)
            measure(&run, rows[i].name, n, 1, &t);
        if (run.status == KD_OK && rows[i].threads && run.threads > 1)
            measure(&run, rows[i].name, n, run.threads, &t);
        free(t.a);
        free(t.b);
        free(t.c);
    }
    bench_close(&run);
    return run.status;
}
