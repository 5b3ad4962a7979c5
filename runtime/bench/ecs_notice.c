/* Noticing: which rows changed since a version, what marking them costs, and who is told of new ones. */
#include "runtime/bench/ecs_cases.h"
#include "runtime/ecs/observer.h"

enum { QUERIES = 1000, APART = 16 };

/* ---- observers ---- */
static void count_event(kd_world *w, const kd_observed *what, void *user)
{
    uint32_t *count = user;
    (void)w;
    (void)what;
    ++*count;
}

static void bench_observed_create(bench_run *run, uint32_t n, kd_entity *e)
{
    bench b = bench_begin(run, "create3_onset_observer", n, "ns/entity", n);
    while (bench_wanted(run, b.name) && bench_more(&b)) {
        kd_world *w = bench_world(run);
        uint32_t told = 0;
        if (!w)
            return;
        if (kd_observe(w, &bench_position_desc, KD_ON_ADD, count_event, &told) != KD_OK)
            bench_fail(run);
        bench_start(&b);
        bench_fill(w, e, n);
        bench_stop(&b);
        if (told != n)
            bench_fail(run);
        kd_world_destroy(w);
    }
    bench_report(&b);
}

/* ---- changes ---- */
static float sum_changed(kd_query *q, uint64_t since)
{
    float sum = 0;
    kd_iter it = kd_query_iter(q);
    it.changed_since = since;
    while (kd_iter_next(&it)) {
        const bench_position *p = KD_COLUMN(&it, bench_position, 0);
        for (uint32_t i = 0; i < it.count; i++)
            sum += p[i].x;
    }
    return sum;
}

static void bench_none_changed(bench_run *run, kd_world *w, uint32_t n, kd_query *q)
{
    uint64_t since = kd_world_version(w);
    bench b = bench_begin(run, "changed_none_per_query", n, "ns/query", QUERIES);
    while (bench_more(&b)) {
        float sum = 0;
        bench_start(&b);
        for (int i = 0; i < QUERIES; i++)
            sum += sum_changed(q, since);
        bench_stop(&b);
        bench_sink = (double)sum;
    }
    bench_report(&b);
}

/* One entity of sixteen was written by its handle; both the marking and the visit of what changed are timed.
 */
static void bench_some_changed(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e, kd_query *q)
{
    bench mark = bench_begin(run, "changed_mark_modified", n, "ns/mark", (n + APART - 1) / APART);
    bench scan = bench_begin(run, "changed_1of16_scan", n, "ns/entity", n);
    while (bench_more(&mark)) {
        uint64_t since = kd_world_version(w);
        bench_start(&mark);
        for (uint32_t i = 0; i < n; i += APART)
            kd_find_mut(w, e[i], bench_position)->x += 1;
        bench_stop(&mark);
        bench_start(&scan);
        float sum = sum_changed(q, since);
        bench_stop(&scan);
        bench_sink = (double)sum;
    }
    bench_report(&mark);
    bench_report(&scan);
}

static void bench_changes(bench_run *run, uint32_t n, kd_entity *e)
{
    bool none = bench_wanted(run, "changed_none_per_query");
    bool some = bench_wanted(run, "changed_mark_modified") || bench_wanted(run, "changed_1of16_scan");
    kd_world *w = none || some ? bench_fragmented(run, n, 3, e) : NULL;
    if (!w)
        return;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(bench_position)}});
    if (!q)
        bench_fail(run);
    if (q && none)
        bench_none_changed(run, w, n, q);
    if (q && some)
        bench_some_changed(run, w, n, e, q);
    kd_world_destroy(w);
}

void bench_ecs_notice(bench_run *run, uint32_t n, kd_entity *e)
{
    bench_observed_create(run, n, e);
    bench_changes(run, n, e);
}
