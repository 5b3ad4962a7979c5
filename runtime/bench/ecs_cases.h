#ifndef KD_BENCH_ECS_CASES_H
#define KD_BENCH_ECS_CASES_H

/* The components, worlds and case groups of the ECS workloads. An entity carries position, velocity and
 * health: 32 bytes. */

#include "runtime/bench/sample.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/world.h"

typedef struct bench_position {
    float x, y, z;
} bench_position;
typedef struct bench_velocity {
    float x, y, z;
} bench_velocity;
typedef struct bench_health {
    int32_t now, most;
} bench_health;
typedef struct bench_extra {
    float value;
} bench_extra;
typedef struct bench_sparse { /* beside the tables */
    float value;
} bench_sparse;
KD_COMPONENT_DECLARE(bench_sparse);
KD_COMPONENT_DECLARE(bench_position);
KD_COMPONENT_DECLARE(bench_velocity);
KD_COMPONENT_DECLARE(bench_health);
KD_COMPONENT_DECLARE(bench_extra);

/** Make a world; after a failure NULL and the run has failed. */
kd_world *bench_world(bench_run *run);
/** Make n entities, one by one. */
void bench_fill(kd_world *w, kd_entity *e, uint32_t n);
/** Make a world of n entities with `bits` (up to 8) optional components beside the three, interleaved: 2^bits
 * archetypes. */
kd_world *bench_fragmented(bench_run *run, uint32_t n, uint32_t bits, kd_entity *e);
void bench_shuffle(kd_entity *e, uint32_t n);
/** Query that writes position (column 0) and reads velocity (column 1). */
kd_query *bench_moving(kd_world *w);
/** position += velocity dt, over the whole query. */
void bench_iterate(kd_query *q);
/** The step itself, over plain arrays. */
void bench_step(bench_position *restrict p, const bench_velocity *restrict v, uint32_t n);

/* Groups of cases; `e` has room for n handles, bench_ecs_tree and bench_ecs_frame are run once. */
void bench_ecs_iterate(bench_run *run, uint32_t n, kd_entity *e);
void bench_ecs_access(bench_run *run, uint32_t n, kd_entity *e);
void bench_ecs_create(bench_run *run, uint32_t n, kd_entity *e);
void bench_ecs_change(bench_run *run, uint32_t n, kd_entity *e);
void bench_ecs_notice(bench_run *run, uint32_t n, kd_entity *e);
void bench_ecs_snapshot(bench_run *run, uint32_t n, kd_entity *e);
void bench_ecs_tree(bench_run *run);
void bench_ecs_frame(bench_run *run);

#endif
