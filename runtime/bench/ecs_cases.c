#include "runtime/bench/ecs_cases.h"

#include <stdlib.h>

#define DT 0.016f

KD_COMPONENT_DEFINE(bench_position, "position", KD_FIELD(bench_position, x, KD_VEC3, "m", "place"));
KD_COMPONENT_DEFINE(bench_velocity, "velocity", KD_FIELD(bench_velocity, x, KD_VEC3, "m/s", "speed"));
KD_COMPONENT_DEFINE(bench_health, "health", KD_FIELD(bench_health, now, KD_I32, NULL, "points left"),
                    KD_FIELD(bench_health, most, KD_I32, NULL, "points at most"));
KD_COMPONENT_DEFINE(bench_extra, "extra", KD_FIELD(bench_extra, value, KD_F32, NULL, "a value"));

KD_COMPONENT_DEFINE_FLAGS(bench_sparse, "sparse", KD_COMPONENT_SPARSE,
                          KD_FIELD(bench_sparse, value, KD_F32, NULL, "a value"));

kd_world *bench_world(bench_run *run)
{
    kd_world *w = run->status == KD_OK ? kd_world_make() : NULL;
    if (!w)
        bench_fail(run);
    return w;
}

void bench_fill(kd_world *w, kd_entity *e, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        e[i] = kd_spawn(w, KD_VAL(bench_position, {(float)i, (float)i, (float)i}),
                        KD_VAL(bench_velocity, {1, 1, 1}), KD_VAL(bench_health, {10, 10}));
}

kd_world *bench_fragmented(bench_run *run, uint32_t n, uint32_t bits, kd_entity *e)
{
    static const kd_component_desc extras[8] = {
        {.name = "x0", .size = 4, .align = 4}, {.name = "x1", .size = 4, .align = 4},
        {.name = "x2", .size = 4, .align = 4}, {.name = "x3", .size = 4, .align = 4},
        {.name = "x4", .size = 4, .align = 4}, {.name = "x5", .size = 4, .align = 4},
        {.name = "x6", .size = 4, .align = 4}, {.name = "x7", .size = 4, .align = 4},
    };
    kd_world *w = bench_world(run);
    if (!w)
        return NULL;
    bench_fill(w, e, n);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t c = 0; c < bits; c++)
            if (i >> c & 1)
                kd_set_value(w, e[i], (kd_value){&extras[c], NULL});
    return w;
}

void bench_shuffle(kd_entity *e, uint32_t n)
{
    uint32_t s = 1;
    for (uint32_t i = n - 1; i > 0; i--) {
        uint32_t j = bench_random(&s) % (i + 1);
        kd_entity moved = e[i];
        e[i] = e[j];
        e[j] = moved;
    }
}

kd_query *bench_moving(kd_world *w)
{
    return kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(bench_position), KD_READ(bench_velocity)}});
}

__attribute__((noinline)) void bench_step(bench_position *restrict p, const bench_velocity *restrict v,
                                          uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        p[i].x += v[i].x * DT;
        p[i].y += v[i].y * DT;
        p[i].z += v[i].z * DT;
    }
}

void bench_iterate(kd_query *q)
{
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        bench_step(KD_COLUMN_MUT(&it, bench_position, 0), KD_COLUMN(&it, bench_velocity, 1), it.count);
}

kd_status kd_bench_ecs(const kd_bench_desc *desc)
{
    static const uint32_t sizes[] = {1000, 65536, 1000000};
    bench_run run;
    kd_status status = bench_open(&run, desc, "ecs");
    if (status != KD_OK)
        return status;
    for (size_t i = 0; i < (desc->n ? 1 : sizeof sizes / sizeof *sizes); i++) {
        uint32_t n = desc->n ? desc->n : sizes[i];
        kd_entity *e = bench_alloc(&run, n, sizeof *e);
        if (e) {
            bench_ecs_iterate(&run, n, e);
            bench_ecs_access(&run, n, e);
            bench_ecs_create(&run, n, e);
            bench_ecs_change(&run, n, e);
            bench_ecs_notice(&run, n, e);
            bench_ecs_snapshot(&run, n, e);
        }
        free(e);
    }
    bench_ecs_tree(&run);
    bench_ecs_frame(&run);
    bench_close(&run);
    return run.status;
}
