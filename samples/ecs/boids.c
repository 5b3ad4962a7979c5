/* Boids: flocks of birds that hatch, fly together and die.
 *
 *     boids [BIRDS] [STEPS] [THREADS]        100000 birds, 100 steps and 2 threads when nothing is given
 *
 * A flock is an entity, its birds are its children. A step is five systems: birds are sorted into cells of
 * space, flocks look at their birds, birds steer, birds fly (and die of age), flocks hatch new ones. All
 * loops over birds are shared among the threads; the checksum printed at the end is the same with any number
 * of them.
 *
 * Source: Reynolds 1987, Flocks, Herds, and Schools, section 4: separation, alignment, cohesion. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/system.h"
#include "runtime/ecs/world.h"
#include "runtime/jobs/jobs.h"

/* ---- components ---- */
typedef struct vec {
    float x, y, z;
} vec;
typedef struct place { /* metres */
    vec at;
} place;
typedef struct motion { /* metres a second */
    vec speed;
} motion;
typedef struct life {
    float left_s;
} life;
typedef struct flock {
    vec centre, heading; /* means over its birds */
    uint32_t birds, wanted, hatched;
} flock;

KD_COMPONENT_DEFINE(place, "place", KD_FIELD(place, at, KD_VEC3, "m", "where it is"));
KD_COMPONENT_DEFINE(motion, "motion", KD_FIELD(motion, speed, KD_VEC3, "m/s", "where it flies"));
KD_COMPONENT_DEFINE(life, "life", KD_FIELD(life, left_s, KD_F32, "s", "time until it dies"));
KD_COMPONENT_DEFINE(flock, "flock", KD_FIELD(flock, centre, KD_VEC3, "m", "mean place of its birds"),
                    KD_FIELD(flock, heading, KD_VEC3, "m/s", "their mean motion"),
                    KD_FIELD(flock, birds, KD_U32, NULL, "how many there are"),
                    KD_FIELD(flock, wanted, KD_U32, NULL, "how many it hatches up to"),
                    KD_FIELD(flock, hatched, KD_U32, NULL, "how many it ever had"));

enum { SIDE = 64, CELLS = SIDE * SIDE * SIDE, LONGEST_LIFE_S = 20 };
#define CELL_M 4.0f
#define DT_S   (1.0f / 60)

/* Cells of space, the world over and over: how many birds are in each, and their summed places. One of a
 * kind. */
typedef struct cells {
    uint32_t count[CELLS];
    vec sum[CELLS];
} cells;
KD_COMPONENT_DEFINE_FLAGS(cells, "cells", KD_COMPONENT_TRANSIENT,
                          KD_FIELD_ARRAY(cells, count, KD_U32, CELLS, NULL, "birds"));

/* ---- arithmetic ---- */
static vec add(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static vec subtract(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static vec scale(vec a, float by)
{
    return (vec){a.x * by, a.y * by, a.z * by};
}
static float length(vec a)
{
    return sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
}
static vec with_length(vec a, float wanted)
{
    float is = length(a);
    return is > 0 ? scale(a, wanted / is) : (vec){wanted, 0, 0};
}

/* A number in -1 … 1 that depends on what it is asked for alone, so that it is the same on any thread.
 * Source: Jarzynski and Olano 2020, PCG hashes. */
static float random_signed(uint32_t of)
{
    of = of * 747796405u + 2891336453u;
    of = ((of >> ((of >> 28) + 4)) ^ of) * 277803737u;
    return (float)((of >> 22 ^ of) >> 8) / 8388608.0f - 1;
}
static vec random_vec(uint32_t of)
{
    return (vec){random_signed(of * 3), random_signed(of * 3 + 1), random_signed(of * 3 + 2)};
}

static uint32_t cell_of(vec at)
{
    uint32_t x = (uint32_t)(int32_t)floorf(at.x / CELL_M) % SIDE,
             y = (uint32_t)(int32_t)floorf(at.y / CELL_M) % SIDE;
    return (((uint32_t)(int32_t)floorf(at.z / CELL_M) % SIDE) * SIDE + y) * SIDE + x;
}

/* ---- systems ---- */
typedef struct queries { /* made once; every system has them as its user */
    kd_query *birds, *flocks;
} queries;

static void sort_into_cells(kd_system_context *context)
{
    cells *c = kd_singleton(context->world, cells);
    const queries *q = context->user;
    memset(c, 0, sizeof *c);
    for (kd_iter it = kd_query_iter(q->birds); kd_iter_next(&it);) {
        const place *p = KD_COLUMN(&it, place, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            uint32_t cell = cell_of(p[i].at);
            c->count[cell]++;
            c->sum[cell] = add(c->sum[cell], p[i].at);
        }
    }
}

static void look_at_birds(kd_iter *rows, kd_commands *commands, void *user)
{
    kd_world *w = user;
    flock *f = KD_COLUMN_MUT(rows, flock, 0);
    kd_lookup place_of = KD_LOOKUP(w, place), motion_of = KD_LOOKUP(w, motion);
    (void)commands;
    for (uint32_t i = 0; i < rows->count; i++) {
        vec places = {0}, speeds = {0};
        uint32_t birds = 0;
        for (kd_entity e = kd_first_child(w, rows->entities[i]); e.generation;
             e = kd_next_sibling(w, e), birds++) {
            const place *p = kd_lookup_find(&place_of, e);
            const motion *m = kd_lookup_find(&motion_of, e);
            places = add(places, p->at);
            speeds = add(speeds, m->speed);
        }
        f[i].birds = birds;
        f[i].centre = scale(places, birds ? 1 / (float)birds : 0);
        f[i].heading = scale(speeds, birds ? 1 / (float)birds : 0);
    }
}

static void gather_flocks(kd_system_context *context)
{
    const queries *q = context->user;
    kd_query_parallel(q->flocks, context->jobs, context->command_key, look_at_birds, context->world);
}

static void steer_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    kd_world *w = user;
    const cells *c = kd_singleton(w, cells);
    const place *p = KD_COLUMN(rows, place, 0);
    motion *m = KD_COLUMN_MUT(rows, motion, 1);
    kd_lookup flock_of = KD_LOOKUP(w, flock);
    (void)commands;
    for (uint32_t i = 0; i < rows->count; i++) {
        const flock *f = kd_lookup_find(&flock_of, rows->parents[i]);
        uint32_t cell = cell_of(p[i].at);
        vec crowd = scale(c->sum[cell], 1 / (float)c->count[cell]); /* the bird itself is in it */
        vec wish = scale(subtract(f->centre, p[i].at), 0.3f);
        wish = add(wish, scale(subtract(f->heading, m[i].speed), 0.8f));
        wish = add(wish, scale(subtract(p[i].at, crowd), 1.5f));
        m[i].speed = with_length(add(m[i].speed, scale(wish, DT_S)), 10);
    }
}

static void steer(kd_system_context *context)
{
    const queries *q = context->user;
    kd_query_parallel(q->birds, context->jobs, context->command_key, steer_rows, context->world);
}

static void fly_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    place *p = KD_COLUMN_MUT(rows, place, 0);
    const motion *m = KD_COLUMN(rows, motion, 1);
    life *l = KD_COLUMN_MUT(rows, life, 2);
    (void)user;
    for (uint32_t i = 0; i < rows->count; i++) {
        p[i].at = add(p[i].at, scale(m[i].speed, DT_S));
        l[i].left_s -= DT_S;
        if (l[i].left_s <= 0)
            kd_commands_destroy(commands, rows->entities[i]);
    }
}

static void fly(kd_system_context *context)
{
    const queries *q = context->user;
    kd_query_parallel(q->birds, context->jobs, context->command_key, fly_rows, NULL);
}

static void hatch_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    flock *f = KD_COLUMN_MUT(rows, flock, 0);
    (void)user;
    for (uint32_t i = 0; i < rows->count; i++)
        for (uint32_t missing = f[i].wanted - f[i].birds; missing; missing--) {
            uint32_t seed = rows->entities[i].index * 1000003u + f[i].hatched++;
            kd_value egg[] = {KD_VAL(place, {add(f[i].centre, scale(random_vec(seed), 20))}),
                              KD_VAL(motion, {with_length(random_vec(seed + 1), 10)}),
                              KD_VAL(life, {(random_signed(seed) + 1) * LONGEST_LIFE_S / 2 + 1})};
            kd_entity bird = kd_commands_spawn(commands, egg, 3);
            kd_commands_set_parent(commands, bird, rows->entities[i]);
        }
}

static void hatch(kd_system_context *context)
{
    const queries *q = context->user;
    kd_query_parallel(q->flocks, context->jobs, context->command_key, hatch_rows, NULL);
}

/* ---- the program ---- */
static kd_status add_systems(kd_schedule *s, queries *q)
{
    const kd_system_desc systems[] = {
        {.name = "cells",
         .run = sort_into_cells,
         .components = {KD_USES(place), KD_CHANGES(cells)},
         .no_commands = true},
        {.name = "flocks",
         .run = gather_flocks,
         .components = {KD_USES(place), KD_USES(motion), KD_CHANGES(flock)},
         .no_commands = true},
        {.name = "steer",
         .run = steer,
         .components = {KD_USES(place), KD_USES(flock), KD_USES(cells), KD_CHANGES(motion)},
         .no_commands = true},
        {.name = "fly", .run = fly, .components = {KD_CHANGES(place), KD_USES(motion), KD_CHANGES(life)}},
        {.name = "hatch", .run = hatch, .components = {KD_CHANGES(flock)}},
    };
    kd_status status = KD_OK;
    for (size_t i = 0; i < sizeof systems / sizeof *systems && !status; i++) {
        kd_system_desc system = systems[i];
        system.phase = KD_PHASE_ANIMATE;
        system.user = q;
        status = kd_schedule_add(s, &system);
    }
    return status;
}

static bool make_flocks(kd_world *w, uint32_t birds)
{
    uint32_t flocks = birds / 1000 + 1;
    for (uint32_t i = 0; i < flocks; i++) {
        flock f = {.centre = scale(random_vec(i), 100),
                   .wanted = birds * (i + 1) / flocks - birds * i / flocks};
        if (!kd_spawn(w, KD_VAL_AT(flock, &f)).generation)
            return false;
    }
    return true; /* the first step hatches the birds */
}

static kd_status run(kd_schedule *s, uint32_t steps, double *step_ms)
{
    kd_status status = kd_schedule_run(s); /* hatches all birds: not counted */
    uint64_t begun = kd_clock_ns();
    for (uint32_t i = 0; i < steps && !status; i++)
        status = kd_schedule_run(s);
    *step_ms = (double)(kd_clock_ns() - begun) / 1e6 / (steps ? steps : 1);
    return status;
}

static kd_status simulate(kd_world *w, kd_schedule *s, uint32_t birds, uint32_t steps, uint32_t threads)
{
    queries q = {.birds = kd_query_make(
                     w, &(kd_query_desc){.terms = {KD_WRITE(place), KD_WRITE(motion), KD_WRITE(life)}}),
                 .flocks = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(flock)}})};
    double step_ms = 0;
    if (!q.birds || !q.flocks || !kd_singleton(w, cells) || !make_flocks(w, birds))
        return KD_NO_MEMORY;
    kd_status status = add_systems(s, &q);
    if (!status)
        status = run(s, steps, &step_ms);
    if (!status)
        printf("%u birds, %u threads: %.2f ms a step, checksum %016llx\n", kd_query_count(q.birds), threads,
               step_ms, (unsigned long long)kd_world_checksum(w));
    return status;
}

static uint32_t argument(int argc, char **argv, int at, uint32_t otherwise)
{
    return argc > at ? (uint32_t)strtoul(argv[at], NULL, 10) : otherwise;
}

int main(int argc, char **argv)
{
    uint32_t threads = argument(argc, argv, 3, 2);
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(threads);
    kd_schedule *s = w && jobs ? kd_schedule_make(w, jobs, NULL) : NULL;
    kd_status status = KD_NO_MEMORY;
    if (s)
        status = simulate(w, s, argument(argc, argv, 1, 100000), argument(argc, argv, 2, 100), threads);
    kd_schedule_destroy(s);
    kd_world_destroy(w);
    kd_jobs_destroy(jobs);
    return status ? 1 : 0;
}
