/* Figures of the ECS beside the plain-array limit of the same run, as JSON rows. `ecs_bench [CASE]` runs the
 * cases whose name contains CASE. The cases and their sizes are the workloads that other libraries were
 * measured with. Times are medians of at least nine samples after one that is thrown away; nothing is
 * asserted. */

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "runtime/ecs/query.h"
#include "runtime/ecs/world.h"

#define DT          0.016f
#define SAMPLES     31
#define LEAST       9
#define BUDGET_NS   4e8 /* measured time after which LEAST samples are enough */
#define TREE_ROOTS  15u
#define TREE_FAN    16u
#define TREE_LEVELS 4u

typedef struct position {
    float x, y, z;
} position;
typedef struct velocity {
    float x, y, z;
} velocity;
typedef struct health {
    int32_t now, most;
} health;
typedef struct extra {
    float value;
} extra;
typedef struct local {
    float x, y, z, s;
} local;
typedef struct placed {
    float x, y, z, s;
} placed;

KD_COMPONENT_DEFINE(position, "position", KD_FIELD(position, x, KD_F32, "m", "x"));
KD_COMPONENT_DEFINE(velocity, "velocity", KD_FIELD(velocity, x, KD_F32, "m/s", "x"));
KD_COMPONENT_DEFINE(health, "health", KD_FIELD(health, now, KD_I32, NULL, "points"));
KD_COMPONENT_DEFINE(extra, "extra", KD_FIELD(extra, value, KD_F32, NULL, "a value"));
KD_COMPONENT_DEFINE(local, "local", KD_FIELD(local, x, KD_F32, "m", "x"));
KD_COMPONENT_DEFINE(placed, "placed", KD_FIELD(placed, x, KD_F32, "m", "x"));

/* ---- samples and rows ---- */
typedef struct bench {
    const char *name;
    uint32_t n;
    double items, limit, spent, begun;
    double samples[SAMPLES];
    int count; /* -1: the next one is thrown away */
} bench;

static const char *filter;
static bool first_row = true;
static volatile float sink;

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static void print_row(const char *name, uint32_t n, const char *unit, double median, double least,
                      double most, double limit)
{
    printf("%s{\"bench\":\"ecs\",\"case\":\"%s\",\"n\":%u,\"threads\":1,\"unit\":\"%s\",\"median\":%.4g,"
           "\"min\":%.4g,"
           "\"max\":%.4g,\"limit\":",
           first_row ? "" : ",\n", name, n, unit, median, least, most);
    if (limit > 0)
        printf("%.4g}", limit);
    else
        printf("null}");
    fflush(stdout);
    first_row = false;
}

static bench begin(const char *name, uint32_t n, double items)
{
    return (bench){.name = name, .n = n, .items = items, .count = -1};
}

static bool wanted(const char *name)
{
    return !filter || strstr(name, filter);
}

static double median(bench *b)
{
    qsort(b->samples, (size_t)b->count, sizeof(double), ascending);
    return b->samples[b->count / 2];
}

static bool more(const bench *b)
{
    return b->count < SAMPLES && (b->count < LEAST || b->spent < BUDGET_NS);
}

static void start(bench *b)
{
    b->begun = now_ns();
}

static void stop(bench *b)
{
    double took = now_ns() - b->begun;
    if (b->count >= 0) {
        b->samples[b->count] = took / b->items;
        b->spent += took;
    }
    b->count++;
}

static double report(bench *b)
{
    double middle = median(b);
    print_row(b->name, b->n, "ns/entity", middle, b->samples[0], b->samples[b->count - 1], b->limit);
    return middle;
}

/* ---- worlds ---- */
static uint32_t next_random(uint32_t *s)
{
    *s ^= *s << 13;
    *s ^= *s >> 17;
    *s ^= *s << 5;
    return *s;
}

static void shuffle(kd_entity *e, uint32_t n)
{
    uint32_t s = 1;
    for (uint32_t i = n - 1; i > 0; i--) {
        uint32_t j = next_random(&s) % (i + 1);
        kd_entity t = e[i];
        e[i] = e[j];
        e[j] = t;
    }
}

static void fill(kd_world *w, kd_entity *e, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        e[i] = kd_spawn(w, KD_VAL(position, {(float)i, (float)i, (float)i}), KD_VAL(velocity, {1, 1, 1}),
                        KD_VAL(health, {10, 10}));
}

static uint32_t repeats(uint32_t n)
{
    return n >= 400000 ? 1 : 400000 / n;
}

__attribute__((noinline)) static void step(position *restrict p, const velocity *restrict v, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        p[i].x += v[i].x * DT;
        p[i].y += v[i].y * DT;
        p[i].z += v[i].z * DT;
    }
}

static void iterate(kd_query *q)
{
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        step(KD_COLUMN_MUT(&it, position, 0), KD_COLUMN(&it, velocity, 1), it.count);
}

static kd_query *moving(kd_world *w)
{
    return kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(position), KD_READ(velocity)}});
}

/* ---- cases ---- */
static double plain_iter(uint32_t n)
{
    uint32_t inner = repeats(n);
    position *p = aligned_alloc(64, (n * sizeof *p + 63) & ~(size_t)63);
    velocity *v = aligned_alloc(64, (n * sizeof *v + 63) & ~(size_t)63);
    for (uint32_t i = 0; i < n; i++) {
        p[i] = (position){(float)i, 0, 0};
        v[i] = (velocity){1, 1, 1};
    }
    bench b = begin("plain", n, (double)n * inner);
    while (more(&b)) {
        start(&b);
        for (uint32_t j = 0; j < inner; j++)
            step(p, v, n);
        stop(&b);
    }
    free(p);
    free(v);
    return median(&b);
}

static void bench_iter(uint32_t n, kd_entity *e)
{
    if (!wanted("iter2"))
        return;
    uint32_t inner = repeats(n);
    kd_world *w = kd_world_make();
    fill(w, e, n);
    kd_query *q = moving(w);
    bench b = begin("iter2", n, (double)n * inner);
    b.limit = plain_iter(n);
    while (more(&b)) {
        start(&b);
        for (uint32_t j = 0; j < inner; j++)
            iterate(q);
        stop(&b);
    }
    report(&b);
    kd_world_destroy(w);
}

static void bench_fragments(uint32_t n)
{
    static const char *const names[] = {"x0", "x1", "x2", "x3", "x4", "x5", "x6", "x7"};
    kd_component_desc extras[8];
    if (!wanted("frag256"))
        return;
    uint32_t inner = repeats(n);
    kd_world *w = kd_world_make();
    for (uint32_t c = 0; c < 8; c++)
        extras[c] = (kd_component_desc){.name = names[c], .size = 4, .align = 4};
    for (uint32_t i = 0; i < n; i++) {
        kd_entity e = kd_spawn(w, KD_TAG(position), KD_VAL(velocity, {1, 1, 1}), KD_TAG(health));
        for (uint32_t c = 0; c < 8; c++)
            if (i >> c & 1)
                kd_set_value(w, e, (kd_value){&extras[c], NULL});
    }
    kd_query *q = moving(w);
    bench b = begin("frag256", n, (double)n * inner);
    while (more(&b)) {
        start(&b);
        for (uint32_t j = 0; j < inner; j++)
            iterate(q);
        stop(&b);
    }
    report(&b);
    kd_world_destroy(w);
}

static void bench_create(uint32_t n, kd_entity *e)
{
    bench b = begin("create3", n, n);
    while (wanted(b.name) && more(&b)) {
        kd_world *w = kd_world_make();
        start(&b);
        fill(w, e, n);
        stop(&b);
        kd_world_destroy(w);
    }
    if (wanted(b.name))
        report(&b);
    b = begin("create3_recycle", n, n);
    kd_world *w = kd_world_make();
    while (wanted(b.name) && more(&b)) {
        start(&b);
        fill(w, e, n);
        stop(&b);
        for (uint32_t i = 0; i < n; i++)
            kd_destroy(w, e[i]);
    }
    if (wanted(b.name))
        report(&b);
    kd_world_destroy(w);
}

static void bench_create_bulk(uint32_t n)
{
    if (!wanted("create3_bulk"))
        return;
    position *p = calloc(n, sizeof *p);
    velocity *v = calloc(n, sizeof *v);
    health *h = calloc(n, sizeof *h);
    const kd_component_desc *descs[] = {&position_desc, &velocity_desc, &health_desc};
    const void *columns[] = {p, v, h};
    for (uint32_t i = 0; i < n; i++) {
        p[i].x = (float)i;
        v[i].x = 1;
        h[i].now = 10;
    }
    bench b = begin("create3_bulk", n, n);
    while (more(&b)) {
        kd_world *w = kd_world_make();
        start(&b);
        kd_spawn_n(w, n, descs, columns, 3, NULL);
        stop(&b);
        kd_world_destroy(w);
    }
    report(&b);
    free(p);
    free(v);
    free(h);
}

static void bench_destroy(uint32_t n, kd_entity *e, bool random)
{
    bench b = begin(random ? "destroy_random" : "destroy", n, n);
    if (!wanted(b.name))
        return;
    while (more(&b)) {
        kd_world *w = kd_world_make();
        fill(w, e, n);
        if (random)
            shuffle(e, n);
        start(&b);
        for (uint32_t i = 0; i < n; i++)
            kd_destroy(w, e[i]);
        stop(&b);
        kd_world_destroy(w);
    }
    report(&b);
}

static void bench_add_remove(uint32_t n, kd_entity *e)
{
    if (!wanted("add1") && !wanted("remove1"))
        return;
    kd_world *w = kd_world_make();
    fill(w, e, n);
    bench add = begin("add1", n, n), remove = begin("remove1", n, n);
    while (more(&add)) {
        start(&add);
        for (uint32_t i = 0; i < n; i++)
            kd_add(w, e[i], extra);
        stop(&add);
        start(&remove);
        for (uint32_t i = 0; i < n; i++)
            kd_remove(w, e[i], extra);
        stop(&remove);
    }
    report(&add);
    report(&remove);
    kd_world_destroy(w);
}

static void bench_deferred(uint32_t n, kd_entity *e)
{
    if (!wanted("deferred_add_in_iter"))
        return;
    kd_world *w = kd_world_make();
    fill(w, e, n);
    kd_query *q = moving(w);
    kd_commands *c = kd_world_commands(w, 0);
    bench b = begin("deferred_add_in_iter", n, n);
    while (more(&b)) {
        start(&b);
        for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
            for (uint32_t i = 0; i < it.count; i++)
                kd_commands_set(c, it.entities[i], KD_TAG(extra));
        kd_world_merge(w);
        stop(&b);
        for (uint32_t i = 0; i < n; i++)
            kd_remove(w, e[i], extra);
    }
    report(&b);
    kd_world_destroy(w);
}

static double plain_get(uint32_t n, const kd_entity *e)
{
    uint32_t inner = repeats(n);
    position *p = calloc(n, sizeof *p);
    bench b = begin("plain", n, (double)n * inner);
    while (more(&b)) {
        float sum = 0;
        start(&b);
        for (uint32_t j = 0; j < inner; j++)
            for (uint32_t i = 0; i < n; i++)
                sum += p[e[i].index].x;
        stop(&b);
        sink = sum;
    }
    free(p);
    return median(&b);
}

static void bench_get(uint32_t n, kd_entity *e)
{
    if (!wanted("get_random"))
        return;
    uint32_t inner = repeats(n);
    kd_world *w = kd_world_make();
    fill(w, e, n);
    shuffle(e, n);
    bench b = begin("get_random", n, (double)n * inner);
    b.limit = plain_get(n, e);
    while (more(&b)) {
        float sum = 0;
        start(&b);
        for (uint32_t j = 0; j < inner; j++)
            for (uint32_t i = 0; i < n; i++)
                sum += kd_find(w, e[i], position)->x;
        stop(&b);
        sink = sum;
    }
    report(&b);
    kd_world_destroy(w);
}

static void bench_memory(uint32_t n, kd_entity *e)
{
    if (!wanted("mem_bytes_per_entity"))
        return;
    kd_world *w = kd_world_make();
    size_t before = kd_world_bytes(w);
    fill(w, e, n);
    double each = (double)(kd_world_bytes(w) - before) / n;
    print_row("mem_bytes_per_entity", n, "bytes/entity", each, each, each, 0);
    kd_world_destroy(w);
}

/* ---- the tree ---- */
static uint32_t make_tree(kd_world *w, kd_entity *e)
{
    uint32_t n = 0, low = 0;
    for (uint32_t i = 0; i < TREE_ROOTS; i++)
        e[n++] = kd_spawn(w, KD_VAL(local, {1, 2, 3, 1}), KD_VAL(placed, {0, 0, 0, 1}));
    for (uint32_t level = 1; level < TREE_LEVELS; level++) {
        uint32_t high = n;
        for (uint32_t parent = low; parent < high; parent++)
            for (uint32_t c = 0; c < TREE_FAN; c++)
                e[n++] =
                    kd_spawn_child(w, e[parent], KD_VAL(local, {1, 2, 3, 1}), KD_VAL(placed, {0, 0, 0, 1}));
        low = high;
    }
    return n;
}

static void propagate(kd_world *w, kd_query *q)
{
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        placed *out = KD_COLUMN_MUT(&it, placed, 0);
        const local *l = KD_COLUMN(&it, local, 1);
        if (!it.parents) {
            for (uint32_t i = 0; i < it.count; i++)
                out[i] = (placed){l[i].x, l[i].y, l[i].z, l[i].s};
            continue;
        }
        for (uint32_t i = 0; i < it.count; i++) {
            placed p = *kd_find(w, it.parents[i], placed);
            out[i] = (placed){p.x + p.s * l[i].x, p.y + p.s * l[i].y, p.z + p.s * l[i].z, p.s * l[i].s};
        }
    }
}

static double plain_tree(uint32_t n)
{
    local *l = calloc(n, sizeof *l);
    placed *p = calloc(n, sizeof *p);
    uint32_t *parent = calloc(n, sizeof *parent), at = TREE_ROOTS, low = 0;
    for (uint32_t level = 1; level < TREE_LEVELS; level++) {
        uint32_t high = at;
        for (uint32_t i = low; i < high; i++)
            for (uint32_t c = 0; c < TREE_FAN; c++)
                parent[at++] = i;
        low = high;
    }
    bench b = begin("plain", n, n * 8.0);
    while (more(&b)) {
        start(&b);
        for (int j = 0; j < 8; j++)
            for (uint32_t i = 0; i < n; i++) {
                placed q = i < TREE_ROOTS ? (placed){0, 0, 0, 1} : p[parent[i]];
                p[i] = (placed){q.x + q.s * l[i].x, q.y + q.s * l[i].y, q.z + q.s * l[i].z, q.s * l[i].s};
            }
        stop(&b);
        sink = p[n - 1].x;
    }
    free(l);
    free(p);
    free(parent);
    return median(&b);
}

static void bench_tree(kd_entity *e)
{
    if (!wanted("tree"))
        return;
    uint32_t n = 0;
    bench create = begin("tree_create", 65535, 65535), walk = begin("tree4", 65535, 65535 * 4.0);
    while (more(&create)) {
        kd_world *w = kd_world_make();
        start(&create);
        n = make_tree(w, e);
        stop(&create);
        kd_world_destroy(w);
    }
    report(&create);
    kd_world *w = kd_world_make();
    size_t before = kd_world_bytes(w);
    n = make_tree(w, e);
    double each = (double)(kd_world_bytes(w) - before) / n - 32;
    print_row("tree_overhead_bytes", n, "bytes/node", each, each, each, 0);
    kd_query *q =
        kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(placed), KD_READ(local)}, .by_depth = true});
    walk.limit = plain_tree(n);
    while (more(&walk)) {
        start(&walk);
        for (int j = 0; j < 4; j++)
            propagate(w, q);
        stop(&walk);
    }
    report(&walk);
    const placed *last = kd_find(w, e[n - 1], placed);
    if (last->x != 4 || last->y != 8 || last->z != 12)
        fprintf(stderr, "ecs_bench: tree4: wrong result\n");
    kd_world_destroy(w);
}

static void bench_world(void)
{
    bench b = begin("world_make_destroy", 1, 100);
    if (!wanted(b.name))
        return;
    while (more(&b)) {
        start(&b);
        for (int i = 0; i < 100; i++)
            kd_world_destroy(kd_world_make());
        stop(&b);
    }
    double middle = median(&b);
    print_row(b.name, 1, "ns/world", middle, b.samples[0], b.samples[b.count - 1], 0);
}

int main(int argc, char **argv)
{
    static const uint32_t sizes[] = {1000, 65536, 1000000};
    filter = argc > 1 ? argv[1] : NULL;
    printf("{\"rows\":[\n");
    for (int i = 0; i < 3; i++) {
        uint32_t n = sizes[i];
        kd_entity *e = malloc((n > 65536 ? n : 65536) * sizeof *e);
        bench_iter(n, e);
        bench_fragments(n);
        bench_create(n, e);
        bench_create_bulk(n);
        bench_destroy(n, e, false);
        bench_destroy(n, e, true);
        bench_add_remove(n, e);
        bench_deferred(n, e);
        bench_get(n, e);
        bench_memory(n, e);
        if (i == 1)
            bench_tree(e);
        free(e);
    }
    bench_world();
    printf("\n]}\n");
    return 0;
}
