/* Loops over queries, and access by handle in random order. */
#include <stdlib.h>

#include "runtime/bench/ecs_cases.h"

typedef struct plain_arrays {
    bench_position *p;
    bench_velocity *v;
} plain_arrays;

static void plain_share(void *user, uint32_t begin, uint32_t end)
{
    plain_arrays *a = user;
    bench_step(a->p + begin, a->v + begin, end - begin);
}

static double time_plain(bench_run *run, uint32_t n, uint32_t threads, plain_arrays *a)
{
    uint32_t inner = bench_repeats(n);
    bench b = bench_begin(run, "plain", n, "ns/entity", (double)n * inner);
    while (bench_more(&b)) {
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            bench_split(threads, n, plain_share, a);
        bench_stop(&b);
    }
    return bench_median(&b);
}

/* The same step on plain arrays; with threads each takes an equal share, where that is quicker than one
 * thread. */
static double plain_limit(bench_run *run, uint32_t n, uint32_t threads)
{
    plain_arrays a = {bench_alloc(run, n, sizeof *a.p), bench_alloc(run, n, sizeof *a.v)};
    double limit = 0;
    if (a.p && a.v) {
        double split = threads > 1 && n >= 10000 ? time_plain(run, n, threads, &a) : 0;
        limit = time_plain(run, n, 1, &a);
        if (split > 0 && split < limit)
            limit = split;
    }
    free(a.p);
    free(a.v);
    return limit;
}

static void bench_query(bench_run *run, const char *name, uint32_t n, double visited, kd_query *q,
                        double limit)
{
    uint32_t inner = bench_repeats(n);
    bench b = bench_begin(run, name, n, "ns/entity", visited * inner);
    b.limit = limit;
    while (bench_more(&b)) {
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            bench_iterate(q);
        bench_stop(&b);
    }
    bench_report(&b);
}

static void step_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    (void)commands;
    (void)user;
    bench_step(KD_COLUMN_MUT(rows, bench_position, 0), KD_COLUMN(rows, bench_velocity, 1), rows->count);
}

static void bench_query_split(bench_run *run, uint32_t n, kd_query *q)
{
    uint32_t inner = bench_repeats(n);
    bench b = bench_begin(run, "iter2", n, "ns/entity", (double)n * inner);
    b.threads = run->threads;
    b.limit = plain_limit(run, n, run->threads);
    while (bench_more(&b)) {
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            if (kd_query_parallel(q, run->jobs, 0, step_rows, NULL) != KD_OK)
                bench_fail(run);
        bench_stop(&b);
    }
    bench_report(&b);
}

static void bench_fragments(bench_run *run, const char *name, uint32_t n, uint32_t bits, kd_entity *e)
{
    kd_world *w = bench_wanted(run, name) ? bench_fragmented(run, n, bits, e) : NULL;
    if (!w)
        return;
    bench_query(run, name, n, n, bench_moving(w), plain_limit(run, n, 1));
    kd_world_destroy(w);
}

static void bench_one_of_eight(bench_run *run, uint32_t n)
{
    kd_world *w = bench_wanted(run, "iter2_1of8_match") ? bench_world(run) : NULL;
    if (!w)
        return;
    for (uint32_t i = 0; i < n; i++) {
        kd_entity e = kd_spawn(w, KD_VAL(bench_position, {1, 1, 1}));
        if (i % 8 == 0)
            kd_set(w, e, bench_velocity, {1, 1, 1});
    }
    bench_query(run, "iter2_1of8_match", n, (n + 7) / 8, bench_moving(w), plain_limit(run, (n + 7) / 8, 1));
    kd_world_destroy(w);
}

void bench_ecs_iterate(bench_run *run, uint32_t n, kd_entity *e)
{
    kd_world *w = bench_wanted(run, "iter2") ? bench_world(run) : NULL;
    if (w) {
        bench_fill(w, e, n);
        bench_query(run, "iter2", n, n, bench_moving(w), plain_limit(run, n, 1));
        if (run->threads > 1)
            bench_query_split(run, n, bench_moving(w));
        kd_world_destroy(w);
    }
    bench_fragments(run, "frag8", n, 3, e);
    bench_fragments(run, "frag256", n, 8, e);
    bench_one_of_eight(run, n);
}

/* ---- by handle ---- */

static double plain_get(bench_run *run, uint32_t n, const kd_entity *e)
{
    uint32_t inner = bench_repeats(n);
    bench_position *p = bench_alloc(run, (size_t)n + 2, sizeof *p); /* indices of handles may begin at 1 */
    bench b = bench_begin(run, "plain", n, "ns/entity", (double)n * inner);
    while (p && bench_more(&b)) {
        float sum = 0;
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            for (uint32_t i = 0; i < n; i++)
                sum += p[e[i].index % (n + 2)].x;
        bench_stop(&b);
        bench_sink = (double)sum;
    }
    free(p);
    return bench_median(&b);
}

static void bench_get(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    uint32_t inner = bench_repeats(n);
    bench b = bench_begin(run, "get_random", n, "ns/entity", (double)n * inner);
    b.limit = plain_get(run, n, e);
    while (bench_more(&b)) {
        float sum = 0;
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            for (uint32_t i = 0; i < n; i++)
                sum += kd_find(w, e[i], bench_position)->x;
        bench_stop(&b);
        bench_sink = (double)sum;
    }
    bench_report(&b);
}

static void bench_get_lookup(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    uint32_t inner = bench_repeats(n);
    kd_lookup positions = KD_LOOKUP(w, bench_position);
    bench b = bench_begin(run, "get_random_lookup", n, "ns/entity", (double)n * inner);
    b.limit = plain_get(run, n, e);
    while (bench_more(&b)) {
        float sum = 0;
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            for (uint32_t i = 0; i < n; i++) {
                const bench_position *p = kd_lookup_find(&positions, e[i]);
                sum += p->x;
            }
        bench_stop(&b);
        bench_sink = (double)sum;
    }
    bench_report(&b);
}

static void bench_alive(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    uint32_t inner = bench_repeats(n);
    bench b = bench_begin(run, "is_alive_random", n, "ns/entity", (double)n * inner);
    while (bench_more(&b)) {
        uint32_t alive = 0;
        bench_start(&b);
        for (uint32_t j = 0; j < inner; j++)
            for (uint32_t i = 0; i < n; i++)
                alive += kd_alive(w, e[i]);
        bench_stop(&b);
        bench_sink = alive;
    }
    bench_report(&b);
}

void bench_ecs_access(bench_run *run, uint32_t n, kd_entity *e)
{
    bool get = bench_wanted(run, "get_random"), lookup = bench_wanted(run, "get_random_lookup"),
         alive = bench_wanted(run, "is_alive_random");
    kd_world *w = get || lookup || alive ? bench_world(run) : NULL;
    if (!w)
        return;
    bench_fill(w, e, n);
    bench_shuffle(e, n);
    if (get)
        bench_get(run, w, n, e);
    if (lookup)
        bench_get_lookup(run, w, n, e);
    if (alive)
        bench_alive(run, w, n, e);
    kd_world_destroy(w);
}
