/* Random programs that use everything at once, run with 1, 2 and 4 threads: loops on all threads that record
 * commands, systems side by side, observers, copies, deaths by query, snapshots. After every step the worlds
 * have the same checksum and the same events were told in the same order. KANDIL_SLOW=1 runs more and longer
 * programs. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/system.h"
#include "runtime/ecs/validate.h"
#include "runtime/jobs/jobs.h"
#include "tests/unit/ecs_fixture.h"

typedef struct charge { /* comes and goes: beside the tables, with enable bits */
    float amount;
} charge;
typedef struct lamp { /* in the tables, with enable bits */
    uint32_t power;
} lamp;
KD_COMPONENT_DEFINE_FLAGS(charge, "charge", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(charge, amount, KD_F32, "C", "how much"));
KD_COMPONENT_DEFINE_FLAGS(lamp, "lamp", KD_COMPONENT_TOGGLE, KD_FIELD(lamp, power, KD_U32, "W", "power"));
typedef struct likes {
    float how_much;
} likes;
KD_RELATION_DEFINE(likes, "likes", 0, KD_FIELD(likes, how_much, KD_F32, NULL, "0 to 1"));
KD_RELATION_TAG_DEFINE(owned_by, "owned_by", KD_COMPONENT_EXCLUSIVE | KD_COMPONENT_CASCADE);
static const kd_component_desc marked_desc = {.name = "marked", .align = 1, .flags = KD_COMPONENT_SPARSE};

#ifdef __SANITIZE_THREAD__
#define SEEDS 8 /* everything takes its time there */
#else
#define SEEDS 24
#endif
enum { KINDS = 8, QUERIES = 7, STEPS = 60, KEEP_BELOW = 5000 };
static const kd_component_desc *const kinds[KINDS] = {&position_desc, &velocity_desc, &health_desc,
                                                      &bond_desc,     &frozen_desc,   &charge_desc,
                                                      &lamp_desc,     &marked_desc};
static const kd_query_desc query_descs[QUERIES] = {
    {{KD_WRITE(position)}, false, NULL},
    {{KD_WRITE(health), KD_WITHOUT(frozen)}, true, NULL},
    {{KD_WRITE(charge), KD_WRITE(position)}, false, NULL},
    {{KD_READ(lamp), KD_OPTIONAL(charge)}, true, NULL},
    {{KD_ANY(velocity), KD_ANY(bond), KD_WITHOUT(marked)}, false, NULL},
    {.by_depth = false},
    {.terms = {KD_READ(likes), KD_OPTIONAL(owned_by), KD_READ(health)}},
};

typedef struct program {
    kd_world *w;
    kd_jobs *jobs;
    kd_schedule *schedule;
    kd_query *queries[QUERIES];
    uint64_t random; /* of the thread that owns the world */
    uint32_t step;
    uint64_t events; /* hash of what observers were told */
    kd_query *looped;
} program;

static uint64_t mix(uint64_t x)
{
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

static void hear(kd_world *w, const kd_observed *what, void *user)
{
    program *p = user;
    uint64_t component = (uint64_t)what->component->name[0] << 8 | (uint64_t)what->component->name[1];
    p->events = mix(p->events ^ ((uint64_t)what->entity.index << 32 | what->entity.generation)) + component +
                (uint64_t)what->event;
    if (what->event == KD_ON_ADD && p->events % 64 == 0) /* an observer that changes the world itself */
        kd_set(w, what->entity, lamp, {what->entity.index});
}

/* ---- on all threads: a row's fate hangs on its handle and the step alone ---- */
static void record_row(kd_commands *c, kd_entity e, kd_entity other, uint64_t random)
{
    position p = {(float)(random % 1000), 1, 2};
    const kd_component_desc *kind = kinds[random >> 20 & (KINDS - 1)];
    kd_entity made;
    switch (random >> 10 & 31) {
    case 0:
    case 1: kd_commands_destroy(c, e); break;
    case 2:
        made = kd_commands_spawn(c, (kd_value[]){KD_VAL_AT(position, &p), KD_VAL(bond, {e, 3})}, 2);
        kd_commands_set_parent(c, made, e);
        kd_commands_set(c, e, KD_VAL(bond, {made, 4}));
        break;
    case 3: kd_commands_spawn(c, (kd_value[]){{kind, NULL}, KD_TAG(health)}, 2); break;
    case 4:
    case 5:
    case 6: kd_commands_set(c, e, (kd_value){kind, NULL}); break;
    case 7:
    case 8: kd_commands_remove(c, e, kind); break;
    case 9: kd_commands_enable(c, e, random & 1 ? &charge_desc : &lamp_desc, random >> 1 & 1); break;
    case 10: kd_commands_set_parent(c, e, random & 3 ? other : KD_NO_ENTITY); break;
    case 11: kd_commands_set_name(c, e, random & 1 ? "one name" : "another"); break;
    default: break;
    }
}

static void visit_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    const program *p = user;
    kd_entity before = KD_NO_ENTITY;
    position *places = p->looped == p->queries[0] ? KD_COLUMN_MUT(rows, position, 0) : NULL;
    for (uint32_t i = 0; i < rows->count; i++) {
        kd_entity e = rows->entities[i];
        uint64_t random = mix(((uint64_t)e.index << 32 | e.generation) * 31 + p->step);
        if (places)
            places[i].x += (float)(random % 7);
        /* the row before this one is another one where the rows are cut elsewhere: a neighbour by handle is
         * not */
        before.index = e.index ^ 1;
        before.generation = e.generation;
        record_row(commands, e, before, random);
    }
}

static void loop(kd_system_context *context, program *p, uint32_t query)
{
    p->looped = p->queries[query];
    assert_int_equal(kd_query_parallel(p->queries[query], context ? context->jobs : p->jobs,
                                       context ? context->command_key : 0, visit_rows, p),
                     KD_OK);
}

/* ---- systems: two that run side by side, one that loops on all threads ---- */
static void heal(kd_system_context *context)
{
    const program *p = context->user;
    uint32_t row = 0;
    for (kd_iter it = kd_query_iter(p->queries[1]); kd_iter_next(&it);) {
        health *h = KD_COLUMN_MUT(&it, health, 0);
        for (uint32_t i = 0; i < it.count; i++, row++) {
            h[i].now++;
            if (row % 50 == p->step % 50)
                kd_commands_spawn(context->commands,
                                  (kd_value[]){KD_VAL(health, {(int)row, 1}), KD_TAG(charge)}, 2);
        }
    }
}

static void leak(kd_system_context *context)
{
    const program *p = context->user;
    uint32_t row = 0;
    for (kd_iter it = kd_query_iter(p->queries[2]); kd_iter_next(&it);) {
        charge *c = KD_COLUMN_MUT(&it, charge, 0);
        for (uint32_t i = 0; i < it.count; i++, row++) {
            c[i].amount -= 1;
            if (row % 40 == p->step % 40)
                kd_commands_remove(context->commands, it.entities[i], &charge_desc);
        }
    }
}

static void roam(kd_system_context *context)
{
    loop(context, context->user, 0);
}

static void add_systems(program *p)
{
    const kd_system_desc descs[] = {
        {.name = "heal", .run = heal, .components = {KD_CHANGES(health), KD_USES(frozen)}},
        {.name = "leak", .run = leak, .components = {KD_CHANGES(charge), KD_USES(position)}},
        {.name = "roam", .run = roam, .components = {KD_CHANGES(position)}},
    };
    for (int i = 0; i < 3; i++) {
        kd_system_desc desc = descs[i];
        desc.phase = i < 2 ? KD_PHASE_INPUT : KD_PHASE_ANIMATE;
        desc.user = p;
        assert_int_equal(kd_schedule_add(p->schedule, &desc), KD_OK);
    }
}

/* ---- on the thread that owns the world ---- */
static kd_entity pick(program *p)
{
    kd_query *all = p->queries[5];
    uint32_t count = kd_query_count(all), wanted = count ? random_below(&p->random, count) : 0;
    for (kd_iter it = kd_query_iter(all); kd_iter_next(&it); wanted -= it.count)
        if (wanted < it.count)
            return it.entities[wanted];
    return KD_NO_ENTITY;
}

static void spawn_some(program *p)
{
    const kd_component_desc *descs[3];
    uint32_t first = random_below(&p->random, KINDS);
    for (uint32_t i = 0; i < 3; i++)
        descs[i] = kinds[(first + i * 3) % KINDS];
    assert_int_equal(kd_spawn_n(p->w, 1 + random_below(&p->random, 900), descs, NULL, 3, NULL), KD_OK);
}

static void write_and_restore(program *p)
{
    kd_snapshot s = {0};
    assert_int_equal(kd_snapshot_write(p->w, &s), KD_OK);
    kd_destroy(p->w, pick(p));
    assert_int_equal(kd_snapshot_restore(p->w, s.data, s.size), KD_OK);
    kd_snapshot_fini(&s);
}

/* Circles are among what is recorded, and refused. */
static void assert_fine(kd_status status)
{
    assert_true(status == KD_OK || status == KD_OUT_OF_RANGE);
}

static void step(program *p)
{
    uint32_t op = random_below(&p->random, 16);
    if (kd_entity_count(p->w) > KEEP_BELOW)
        op = 13;
    if (op < 4)
        spawn_some(p);
    else if (op < 8)
        loop(NULL, p, op % QUERIES);
    else if (op < 11)
        assert_fine(kd_schedule_run(p->schedule));
    else if (op == 11 && kd_entity_count(p->w) < KEEP_BELOW / 2)
        kd_instantiate(p->w, pick(p), random_below(&p->random, 2) ? pick(p) : KD_NO_ENTITY, 3, NULL);
    else if (op == 12 && p->step % 3 == 0)
        kd_destroy_query(p->queries[random_below(&p->random, 5)]);
    else if (op == 13)
        kd_set_parent(p->w, pick(p), pick(p));
    else if (op == 14)
        kd_clone(p->w, pick(p));
    else if (op == 15)
        write_and_restore(p);
    if (kd_entity_count(p->w) > KEEP_BELOW)
        for (int i = 0; i < 100; i++)
            kd_destroy(p->w, pick(p));
    assert_fine(kd_world_merge(p->w));
}

typedef struct outcome {
    uint64_t checksum, events, entities;
} outcome;

/* Run a program; outcomes[i] says how the world was after step i. */
static void run_program(uint64_t seed, uint32_t threads, uint32_t steps, outcome *outcomes)
{
    program p = {
        .w = kd_world_make(), .jobs = kd_jobs_make(threads), .random = mix(seed) | 1, .events = seed};
    assert_true(p.w && p.jobs);
    p.schedule = kd_schedule_make(p.w, p.jobs, NULL);
    assert_non_null(p.schedule);
    for (int q = 0; q < QUERIES; q++)
        p.queries[q] = kd_query_make(p.w, &query_descs[q]);
    add_systems(&p);
    assert_int_equal(kd_observe(p.w, &likes_desc, 15, hear, &p), KD_OK);
    for (int k = 0; k < KINDS; k++)
        assert_int_equal(kd_observe(p.w, kinds[k], seed % 3 ? 15 : KD_ON_REMOVE, hear, &p), KD_OK);
    for (uint32_t i = 0; i < steps; i++) {
        p.step = i;
        step(&p);
        outcomes[i] = (outcome){kd_world_checksum(p.w), p.events, kd_entity_count(p.w)};
        if (i % 16 == 0 || i + 1 == steps)
            assert_int_equal(kd_world_validate(p.w), KD_OK);
    }
    kd_schedule_destroy(p.schedule);
    kd_world_destroy(p.w);
    kd_jobs_destroy(p.jobs);
}

static void programs_end_the_same_with_any_number_of_threads(void **state)
{
    static outcome alone[STEPS], together[STEPS];
    bool slow = getenv("KANDIL_SLOW") && *getenv("KANDIL_SLOW") == '1';
    uint64_t seeds = slow ? 1000 : SEEDS;
    uint64_t most = 0;
    (void)state;
    for (uint64_t seed = 1; seed <= seeds; seed++) {
        run_program(seed, 1, STEPS, alone);
        for (uint32_t threads = 2; threads <= 4; threads += 2) {
            run_program(seed, threads, STEPS, together);
            for (uint32_t i = 0; i < STEPS; i++)
                if (memcmp(&alone[i], &together[i], sizeof alone[i]) != 0) {
                    print_error("seed %u, %u threads: step %u differs\n", (unsigned)seed, threads, i);
                    fail();
                }
        }
        for (uint32_t i = 0; i < STEPS; i++)
            most = alone[i].entities > most ? alone[i].entities : most;
    }
    print_message("at most %u entities\n", (unsigned)most);
    assert_true(most > KEEP_BELOW / 2); /* the worlds were not empty all the time */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(programs_end_the_same_with_any_number_of_threads),
    };
    kd_log_set_sink(silent, NULL);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
