/* A hierarchy propagated from the roots down, and what a frame and a system cost when they do nothing. */
#include <stdlib.h>

#include "runtime/bench/ecs_cases.h"
#include "runtime/core/log.h"
#include "runtime/ecs/system.h"

/* 15 roots, 16 children each, 4 levels: 15 (1 + 16 + 256 + 4096) = 65535 nodes. */
enum { ROOTS = 15, FAN = 16, LEVELS = 4, SYSTEMS = 100 };

typedef struct bench_local {
    float x, y, z, s;
} bench_local;
typedef struct bench_placed {
    float x, y, z, s;
} bench_placed;
KD_COMPONENT_DEFINE(bench_local, "local",
                    KD_FIELD(bench_local, x, KD_VEC4, "m", "place and scale in the parent"));
KD_COMPONENT_DEFINE(bench_placed, "placed",
                    KD_FIELD(bench_placed, x, KD_VEC4, "m", "place and scale in the world"));

/* As many levels as fit; the roots always. */
static uint32_t count_levels(uint32_t most, uint32_t *nodes)
{
    uint32_t levels = 1, wide = ROOTS;
    *nodes = ROOTS;
    while (levels < LEVELS && *nodes + wide * FAN <= most) {
        wide *= FAN;
        *nodes += wide;
        levels++;
    }
    return levels;
}

static void make_tree(kd_world *w, kd_entity *e, uint32_t levels)
{
    uint32_t n = 0, low = 0;
    for (uint32_t i = 0; i < ROOTS; i++)
        e[n++] = kd_spawn(w, KD_VAL(bench_local, {1, 2, 3, 1}), KD_VAL(bench_placed, {0, 0, 0, 1}));
    for (uint32_t level = 1; level < levels; level++) {
        uint32_t high = n;
        for (uint32_t parent = low; parent < high; parent++)
            for (uint32_t c = 0; c < FAN; c++)
                e[n++] = kd_spawn_child(w, e[parent], KD_VAL(bench_local, {1, 2, 3, 1}),
                                        KD_VAL(bench_placed, {0, 0, 0, 1}));
        low = high;
    }
}

static void propagate(kd_world *w, kd_query *q)
{
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        bench_placed *out = KD_COLUMN_MUT(&it, bench_placed, 0);
        const bench_local *l = KD_COLUMN(&it, bench_local, 1);
        for (uint32_t i = 0; !it.parents && i < it.count; i++)
            out[i] = (bench_placed){l[i].x, l[i].y, l[i].z, l[i].s};
        for (uint32_t i = 0; it.parents && i < it.count; i++) {
            bench_placed p = *kd_find(w, it.parents[i], bench_placed);
            out[i] = (bench_placed){p.x + p.s * l[i].x, p.y + p.s * l[i].y, p.z + p.s * l[i].z, p.s * l[i].s};
        }
    }
}

static double plain_tree(bench_run *run, uint32_t n)
{
    bench_local *l = bench_alloc(run, n, sizeof *l);
    bench_placed *p = bench_alloc(run, n, sizeof *p);
    uint32_t *parent = bench_alloc(run, n, sizeof *parent);
    bench b = bench_begin(run, "plain", n, "ns/node", n * 8.0);
    for (uint32_t i = ROOTS; parent && i < n; i++)
        parent[i] = (i - ROOTS) / FAN; /* breadth first: the children of node k follow those of k - 1 */
    while (l && p && parent && bench_more(&b)) {
        bench_start(&b);
        for (int j = 0; j < 8; j++)
            for (uint32_t i = 0; i < n; i++) {
                bench_placed q = i < ROOTS ? (bench_placed){0, 0, 0, 1} : p[parent[i]];
                p[i] =
                    (bench_placed){q.x + q.s * l[i].x, q.y + q.s * l[i].y, q.z + q.s * l[i].z, q.s * l[i].s};
            }
        bench_stop(&b);
        bench_sink = (double)p[n - 1].x;
    }
    free(l);
    free(p);
    free(parent);
    return bench_median(&b);
}

static void bench_tree_create(bench_run *run, kd_entity *e, uint32_t levels, uint32_t n)
{
    bench b = bench_begin(run, "tree_create", n, "ns/node", n);
    while (bench_more(&b)) {
        kd_world *w = bench_world(run);
        if (!w)
            return;
        bench_start(&b);
        make_tree(w, e, levels);
        bench_stop(&b);
        kd_world_destroy(w);
    }
    bench_report(&b);
}

/* Sums of 1, 2, 3 over the levels stand at the last leaf. */
static void check_tree(bench_run *run, const kd_world *w, kd_entity leaf, uint32_t levels)
{
    const bench_placed *p = kd_find(w, leaf, bench_placed);
    float depth = (float)levels;
    if (!p || p->x != depth || p->y != 2 * depth || p->z != 3 * depth)
        run->status = kd_fail(KD_OUT_OF_RANGE, "bench: tree4: wrong result; please report this");
}

void bench_ecs_tree(bench_run *run)
{
    uint32_t n, levels = count_levels(bench_size(run, 65535), &n);
    kd_entity *e = bench_wanted(run, "tree4") || bench_wanted(run, "tree_create") ||
                           bench_wanted(run, "tree_mem_B_per_node")
                       ? bench_alloc(run, n, sizeof *e)
                       : NULL;
    if (!e)
        return;
    bench_tree_create(run, e, levels, n);
    kd_world *w = bench_world(run);
    if (w) {
        size_t before = kd_world_bytes(w), payload = sizeof(bench_local) + sizeof(bench_placed);
        make_tree(w, e, levels);
        double each = (double)(kd_world_bytes(w) - before) / n;
        bench_value(run, "tree_mem_B_per_node", n, "bytes/node", each);
        bench_value(run, "tree_overhead_B_per_node", n, "bytes/node", each - (double)payload);
        kd_query *q = kd_query_make(
            w, &(kd_query_desc){.terms = {KD_WRITE(bench_placed), KD_READ(bench_local)}, .by_depth = true});
        bench b = bench_begin(run, "tree4", n, "ns/node", n * 4.0);
        b.limit = plain_tree(run, n);
        while (bench_more(&b)) {
            bench_start(&b);
            for (int j = 0; j < 4; j++)
                propagate(w, q);
            bench_stop(&b);
        }
        bench_report(&b);
        check_tree(run, w, e[n - 1], levels);
    }
    kd_world_destroy(w);
    free(e);
}

/* ---- frames and worlds ---- */

static void no_work(kd_system_context *context)
{
    (void)context;
}

static void bench_frames(bench_run *run, kd_jobs *jobs, const char *name, uint32_t systems)
{
    kd_world *w = bench_wanted(run, name) ? bench_world(run) : NULL;
    kd_schedule *s = w ? kd_schedule_make(w, jobs, NULL) : NULL;
    bench b =
        bench_begin(run, name, systems, systems ? "ns/system" : "ns/frame", 100.0 * (systems ? systems : 1));
    b.threads = kd_jobs_threads(jobs);
    kd_status status = s ? KD_OK : KD_NO_MEMORY;
    for (uint32_t i = 0; i < systems && status == KD_OK; i++)
        status = kd_schedule_add(s, &(kd_system_desc){.name = "nothing",
                                                      .phase = KD_PHASE_ANIMATE,
                                                      .components = {KD_USES(bench_position)},
                                                      .no_commands = true,
                                                      .run = no_work});
    if (status == KD_OK)
        status = kd_schedule_init(s);
    while (status == KD_OK && bench_more(&b)) {
        bench_start(&b);
        for (int j = 0; j < 100; j++)
            status = kd_schedule_run(s);
        bench_stop(&b);
    }
    bench_report(&b);
    if (w && status != KD_OK && run->status == KD_OK)
        run->status = status;
    kd_schedule_destroy(s);
    kd_world_destroy(w);
}

void bench_ecs_frame(bench_run *run)
{
    kd_jobs *alone = kd_jobs_make(1);
    if (!alone) {
        bench_fail(run);
        return;
    }
    for (int i = 0; i < (run->threads > 1 ? 2 : 1); i++) {
        bench_frames(run, i ? run->jobs : alone, "progress_empty_frame", 0);
        bench_frames(run, i ? run->jobs : alone, "progress_per_system_100", SYSTEMS);
    }
    kd_jobs_destroy(alone);
    bench b = bench_begin(run, "world_init_fini", 1, "ns/world", 100);
    while (bench_wanted(run, b.name) && bench_more(&b)) {
        bench_start(&b);
        for (int i = 0; i < 100; i++)
            kd_world_destroy(kd_world_make());
        bench_stop(&b);
    }
    bench_report(&b);
}
