#ifndef KD_ECS_SCHEDULE_INTERNAL_H
#define KD_ECS_SCHEDULE_INTERNAL_H

/* The schedule's data, shared by its sources.
 *
 * The frame is a graph of nodes: one for each system in order of (phase, registration), and a merge behind
 * each phase that may record commands. That order is a legal one by construction: every edge leads from a
 * lower to a higher node. Nodes of the lane (GPU systems and merges) run on worker 0 in node order; the
 * others are jobs. */

#include <stdatomic.h>

#include "runtime/core/arena.h"
#include "runtime/ecs/system.h"
#include "runtime/ecs/watch.h"
#include "runtime/jobs/jobs.h"

enum {
    SCHEDULE_MAX_SYSTEMS = 256,
    SCHEDULE_MAX_NODES = SCHEDULE_MAX_SYSTEMS + KD_PHASE_COUNT,
    SCHEDULE_SET_WORDS = (SCHEDULE_MAX_NODES + 63) / 64,
    SCHEDULE_KEY_SHIFT = 52, /* of command keys: 12 bits node, 20 bits run of the frame, 32 bits row */
    SCHEDULE_ALL_USES = 4095,
    SCHEDULE_SAMPLES = 64,
};
#define SCHEDULE_MERGE UINT32_MAX /* in place of a system: this node merges commands */

typedef struct schedule_set {
    uint64_t words[SCHEDULE_SET_WORDS];
} schedule_set;

static inline void schedule_set_add(schedule_set *set, uint32_t i)
{
    set->words[i / 64] |= (uint64_t)1 << (i % 64);
}
static inline bool schedule_set_has(const schedule_set *set, uint32_t i)
{
    return set->words[i / 64] >> (i % 64) & 1;
}

typedef struct schedule_system {
    kd_system_desc desc;                      /* name is our copy */
    uint16_t resources[KD_MAX_RESOURCE_USES]; /* index of each used resource in the schedule's list */
    bool enabled, initialized;
    uint64_t command_key;
    ecs_watch watch;
    kd_system_statistics counts; /* median_ms is found when asked for */
    uint32_t *samples_ns;        /* [SCHEDULE_SAMPLES] of the latest runs that were measured, NULL: never */
    uint64_t sample_count;
} schedule_system;

typedef struct schedule_node {
    struct kd_schedule *schedule;
    uint32_t system; /* or SCHEDULE_MERGE */
    kd_phase phase;
    schedule_set before, after;    /* edges that the graph needs; none that others imply */
    schedule_set conflicts_before; /* the same without the order of the lane */
    uint32_t before_count;
    kd_job_counter blocked; /* predecessors that have not finished in this frame; no jobs wait for it */
} schedule_node;

/* What memory barriers are still owed for one GPU resource, as kd_gpu_use bits. */
typedef struct schedule_resource {
    const char *name;
    uint32_t stale;     /* uses for which the last shader writes are not visible yet */
    uint32_t unordered; /* shader writes that must not overtake the last reads */
} schedule_resource;

typedef struct schedule_check schedule_check;

struct kd_schedule {
    kd_world *world;
    kd_jobs *jobs;
    struct kd_gpu *gpu;
    kd_jobs *own_jobs; /* made because none was given */
    kd_schedule_hooks hooks;
    uint64_t seed;
    bool init_done;
    bool without_gpu; /* systems of the GPU lane are left out */
    bool measured;
    schedule_check *check;    /* NULL: not checked */
    kd_schedule_clock *clock; /* the world's */

    schedule_system *systems;
    uint32_t system_count;
    schedule_resource *resources;
    uint32_t resource_count;

    bool built;
    schedule_node *nodes;
    uint32_t node_count;
    void **roots; /* nodes that are jobs and wait for nothing */
    uint32_t root_count;

    kd_job_counter unfinished; /* jobs of this frame */
    _Atomic int status;        /* first failure of this frame */
    kd_arena scratch[KD_MAX_WORKERS];
};

static inline bool schedule_on_lane(const kd_schedule *s, const schedule_node *node)
{
    return node->system == SCHEDULE_MERGE || s->systems[node->system].desc.where == KD_ON_GPU;
}

static inline bool schedule_is_left_out(const kd_schedule *s, const schedule_system *system)
{
    return s->without_gpu && system->desc.where == KD_ON_GPU;
}

/* Derive the nodes and edges. Errors NO_MEMORY. */
kd_status schedule_build(kd_schedule *s);

/* Find the barrier that must stand before `system`, and account for it and for what the system does to its
 * resources. `resources` is the state, normally s->resources. Returns kd_gpu_use bits, 0 when no barrier is
 * needed. */
uint32_t schedule_barrier(const kd_schedule *s, const schedule_system *system, schedule_resource *resources);

/* schedule_rate.c */
/** How often the system is due in this frame; *dropped: and how often more than its rate allows. */
uint32_t schedule_due(const kd_schedule *s, const schedule_system *system, uint64_t *dropped);
/** Set time and step of run `left` before the last one due in this frame. */
void schedule_set_time(const kd_schedule *s, const schedule_system *system, uint32_t left,
                       kd_system_context *context);
void schedule_clock_advance(kd_schedule *s);

/* schedule_check.c */
void schedule_check_begin(kd_schedule *s, const schedule_system *system);
/** Compare what the system may not have changed. */
kd_status schedule_check_end(kd_schedule *s, schedule_system *system);
void schedule_check_destroy(schedule_check *c);
/** Prepare its watch for the runs of one frame. */
void schedule_watch(const kd_schedule *s, schedule_system *system);
/** The pool that a system is given: while it is checked all its jobs run on the thread that is watched. */
kd_jobs *schedule_pool(const kd_schedule *s);

/* schedule_statistics.c */
void schedule_add_sample(schedule_system *system, uint64_t ns);

/* schedule_run.c */
kd_system_context schedule_context(kd_schedule *s, const schedule_system *system, uint32_t worker);

#endif
