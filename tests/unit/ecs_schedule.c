/* Order, parallelism, merges and the lane. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "runtime/core/arena.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

typedef struct red {
    uint32_t value;
} red;
typedef struct green {
    uint32_t value;
} green;
typedef struct blue {
    uint32_t value;
} blue;
KD_COMPONENT_DECLARE(red);
KD_COMPONENT_DECLARE(green);
KD_COMPONENT_DECLARE(blue);
KD_COMPONENT_DEFINE(red, "red", KD_FIELD_RANGE(red, value, KD_U32, NULL, 0, 0, "a number"));
KD_COMPONENT_DEFINE(green, "green", KD_FIELD_RANGE(green, value, KD_U32, NULL, 0, 0, "a number"));
KD_COMPONENT_DEFINE(blue, "blue", KD_FIELD_RANGE(blue, value, KD_U32, NULL, 0, 0, "a number"));

static const uint32_t thread_counts[] = {1, 2, 4};

static void quiet(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    (void)text;
}

/* What ran, in order of beginning; `user` of a system is its one-letter name. */
static char trace[256];
static atomic_int trace_length;
static atomic_int wrong_worker;

static void clear_trace(void)
{
    memset(trace, 0, sizeof trace);
    trace_length = 0;
    wrong_worker = 0;
}

static void note(kd_system_context *c)
{
    trace[atomic_fetch_add(&trace_length, 1)] = *(const char *)c->user;
}

static void note_on_lane(kd_system_context *c)
{
    note(c);
    if (c->worker != KD_GPU_LANE || kd_jobs_worker(c->jobs) != KD_GPU_LANE)
        wrong_worker++;
}

typedef struct fixture {
    kd_world *world;
    kd_jobs *jobs;
    kd_schedule *schedule;
} fixture;

static fixture make(uint32_t threads)
{
    fixture f = {.world = kd_world_make(), .jobs = kd_jobs_make(threads)};
    f.schedule = kd_schedule_make(f.world, f.jobs, NULL);
    clear_trace();
    return f;
}

static void destroy(fixture *f)
{
    kd_schedule_destroy(f->schedule);
    kd_jobs_destroy(f->jobs);
    kd_world_destroy(f->world);
}

static void add(fixture *f, kd_system_desc desc)
{
    assert_int_equal(kd_schedule_add(f->schedule, &desc), KD_OK);
}

/* All write red, so the only order is (phase, registration). */
static void conflicting_systems_run_by_phase_then_registration(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        fixture f = make(thread_counts[t]);
        static const kd_phase phases[] = {KD_PHASE_VIEW, KD_PHASE_INPUT, KD_PHASE_CULL, KD_PHASE_INPUT,
                                          KD_PHASE_VIEW};
        static char names[] = "a\0b\0c\0d\0e";
        for (int i = 0; i < 5; i++)
            add(&f, (kd_system_desc){.name = &names[i * 2],
                                     .phase = phases[i],
                                     .components = {KD_CHANGES(red)},
                                     .run = note,
                                     .user = &names[i * 2]});
        for (int frame = 0; frame < 50; frame++) {
            clear_trace();
            assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
            assert_string_equal(trace, "bdcae");
        }
        destroy(&f);
    }
}

/* Two descriptions of one name are one component: systems that know it by either conflict. */
static void systems_conflict_over_two_descriptions_of_a_component(void **state)
{
    (void)state;
    static const kd_component_desc also_red = {.name = "red", .size = sizeof(red), .align = _Alignof(red)};
    fixture f = make(1);
    add(&f, (kd_system_desc){
                .name = "a", .components = {KD_CHANGES(red)}, .no_commands = true, .run = note, .user = "a"});
    add(&f,
        (kd_system_desc){
            .name = "b", .components = {{&also_red, true}}, .no_commands = true, .run = note, .user = "b"});
    for (uint64_t seed = 1; seed <= 64; seed++) {
        kd_schedule_randomize(f.schedule, seed);
        clear_trace();
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
        assert_string_equal(trace, "ab");
    }
    destroy(&f);
}

/* a writes red; b and c read it; d writes it again and must follow both. b and c are free among themselves.
 */
static void readers_run_between_their_writers(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        fixture f = make(thread_counts[t]);
        add(&f,
            (kd_system_desc){
                .name = "a", .components = {KD_CHANGES(red)}, .no_commands = true, .run = note, .user = "a"});
        add(&f, (kd_system_desc){.name = "b", .components = {KD_USES(red)}, .run = note, .user = "b"});
        add(&f, (kd_system_desc){.name = "c", .components = {KD_USES(red)}, .run = note, .user = "c"});
        add(&f,
            (kd_system_desc){
                .name = "d", .components = {KD_CHANGES(red)}, .no_commands = true, .run = note, .user = "d"});
        for (int frame = 0; frame < 100; frame++) {
            clear_trace();
            assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
            assert_true(strcmp(trace, "abcd") == 0 || strcmp(trace, "acbd") == 0);
        }
        destroy(&f);
    }
}

static atomic_int here;
static atomic_int met;

static void meet(kd_system_context *c)
{
    (void)c;
    atomic_fetch_add(&here, 1);
    for (int i = 0; i < 20000 && atomic_load(&here) < 2; i++)
        nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
    atomic_fetch_add(&met, atomic_load(&here) == 2);
}

/* Each waits inside for the other: both meet only if they run at the same time. */
static void independent_systems_meet(kd_system_desc a, kd_system_desc b)
{
    fixture f = make(2);
    here = met = 0;
    a.name = "a";
    b.name = "b";
    a.run = b.run = meet;
    add(&f, a);
    add(&f, b);
    assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_int_equal(met, 2);
    destroy(&f);
}

static void independent_systems_run_at_the_same_time(void **state)
{
    (void)state;
    /* different components of one phase */
    independent_systems_meet((kd_system_desc){.components = {KD_CHANGES(red)}},
                             (kd_system_desc){.components = {KD_CHANGES(green)}});
    /* two readers, in different phases */
    independent_systems_meet((kd_system_desc){.phase = KD_PHASE_INPUT, .components = {KD_USES(red)}},
                             (kd_system_desc){.phase = KD_PHASE_VIEW, .components = {KD_USES(red)}});
    /* writers in different phases that promise to record no commands */
    independent_systems_meet(
        (kd_system_desc){.phase = KD_PHASE_INPUT, .components = {KD_CHANGES(red)}, .no_commands = true},
        (kd_system_desc){.phase = KD_PHASE_VIEW, .components = {KD_CHANGES(green)}, .no_commands = true});
    /* the lane and a worker */
    independent_systems_meet((kd_system_desc){.where = KD_ON_GPU, .resources = {{"x", KD_USE_STORAGE_WRITE}}},
                             (kd_system_desc){.components = {KD_USES(red)}});
}

static void exclusive_system_separates_all_others(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        fixture f = make(thread_counts[t]);
        add(&f, (kd_system_desc){.name = "a", .components = {KD_USES(red)}, .run = note, .user = "a"});
        add(&f, (kd_system_desc){.name = "b", .components = {KD_USES(green)}, .run = note, .user = "a"});
        add(&f, (kd_system_desc){.name = "x", .exclusive = true, .run = note, .user = "x"});
        add(&f, (kd_system_desc){.name = "c", .components = {KD_USES(red)}, .run = note, .user = "c"});
        add(&f, (kd_system_desc){.name = "g", .where = KD_ON_GPU, .run = note, .user = "c"});
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
        assert_string_equal(trace, "aaxcc");
        destroy(&f);
    }
}

/* No conflicts at all, and still the order of (phase, registration) on worker 0. */
static void gpu_systems_keep_their_order_on_the_lane(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        fixture f = make(thread_counts[t]);
        static char names[] = "a\0b\0c\0d\0e\0f";
        for (int i = 0; i < 6; i++)
            add(&f, (kd_system_desc){.name = &names[i * 2],
                                     .phase = i < 3 ? KD_PHASE_VIEW : KD_PHASE_SHADOW,
                                     .where = KD_ON_GPU,
                                     .run = note_on_lane,
                                     .user = &names[i * 2]});
        for (int frame = 0; frame < 20; frame++) {
            clear_trace();
            assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
            assert_string_equal(trace, "defabc");
            assert_int_equal(wrong_worker, 0);
        }
        destroy(&f);
    }
}

static void spawn_three(kd_system_context *c)
{
    for (uint32_t i = 0; i < 3; i++)
        kd_commands_spawn(c->commands, &KD_VAL(red, {i}), 1);
}

static void count_entities(kd_system_context *c)
{
    *(uint32_t *)c->user = kd_entity_count(c->world);
}

static void commands_are_merged_at_the_phase_border(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        fixture f = make(thread_counts[t]);
        uint32_t same_phase = 99, next_phase = 99;
        add(&f, (kd_system_desc){.name = "spawn",
                                 .phase = KD_PHASE_SCRIPT,
                                 .components = {KD_CHANGES(red)},
                                 .run = spawn_three});
        add(&f, (kd_system_desc){.name = "same",
                                 .phase = KD_PHASE_SCRIPT,
                                 .components = {KD_USES(red)},
                                 .run = count_entities,
                                 .user = &same_phase});
        add(&f, (kd_system_desc){.name = "next",
                                 .phase = KD_PHASE_ANIMATE,
                                 .components = {KD_USES(blue)},
                                 .run = count_entities,
                                 .user = &next_phase});
        for (uint32_t frame = 0; frame < 20; frame++) {
            assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
            assert_int_equal(same_phase, frame * 3);
            assert_int_equal(next_phase, frame * 3 + 3);
        }
        destroy(&f);
    }
}

static void record_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    kd_system_context *c = user;
    kd_commands *commands = kd_world_commands(c->world, worker);
    for (uint32_t i = begin; i < end; i++) {
        kd_commands_key(commands, c->command_key + i);
        kd_commands_spawn(commands, &KD_VAL(blue, {i}), 1);
    }
}

static void spawn_in_parallel(kd_system_context *c)
{
    kd_jobs_parallel_for(c->jobs, 200, 3, record_rows, c);
}

static void spawn_green(kd_system_context *c)
{
    for (uint32_t i = 0; i < 20; i++)
        kd_commands_spawn(c->commands, &KD_VAL(green, {i}), 1);
}

static void add_spawners(fixture *f)
{
    add(f, (kd_system_desc){
               .name = "r", .phase = KD_PHASE_SCRIPT, .components = {KD_CHANGES(red)}, .run = spawn_three});
    add(f, (kd_system_desc){
               .name = "g", .phase = KD_PHASE_SCRIPT, .components = {KD_CHANGES(green)}, .run = spawn_green});
    add(f, (kd_system_desc){.name = "b",
                            .phase = KD_PHASE_SCRIPT,
                            .components = {KD_CHANGES(blue)},
                            .run = spawn_in_parallel});
    add(f, (kd_system_desc){
               .name = "n", .phase = KD_PHASE_ANIMATE, .components = {KD_CHANGES(red)}, .run = spawn_three});
}

static uint64_t checksum_after_frames(uint32_t threads, uint64_t seed)
{
    fixture f = make(threads);
    add_spawners(&f);
    kd_schedule_randomize(f.schedule, seed);
    for (int frame = 0; frame < 5; frame++)
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_int_equal(kd_entity_count(f.world), 5 * (3 + 20 + 200 + 3));
    uint64_t checksum = kd_world_checksum(f.world);
    destroy(&f);
    return checksum;
}

/* Systems that spawn side by side, one of them from a parallel loop: same entities, same order, whatever the
 * threads. */
static void world_is_equal_at_any_thread_count_and_order(void **state)
{
    (void)state;
    uint64_t expected = checksum_after_frames(1, 0);
    for (int round = 0; round < 5; round++)
        for (uint32_t threads = 1; threads <= 4; threads++)
            assert_true(checksum_after_frames(threads, 0) == expected);
    for (uint64_t seed = 1; seed <= 20; seed++)
        assert_true(checksum_after_frames(2, seed) == expected);
}

/* r -> s conflict, the others are free; 5 systems in one phase with that one constraint have 60 legal orders.
 */
static void randomize_shuffles_only_what_is_free(void **state)
{
    (void)state;
    char first[16] = "";
    int changes = 0;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        for (int again = 0; again < 2; again++) {
            fixture f = make(2);
            add(&f, (kd_system_desc){.name = "r", .components = {KD_CHANGES(red)}, .run = note, .user = "r"});
            add(&f, (kd_system_desc){.name = "g", .where = KD_ON_GPU, .run = note_on_lane, .user = "g"});
            add(&f, (kd_system_desc){.name = "h", .where = KD_ON_GPU, .run = note_on_lane, .user = "h"});
            add(&f, (kd_system_desc){.name = "u", .components = {KD_USES(blue)}, .run = note, .user = "u"});
            add(&f, (kd_system_desc){.name = "s", .components = {KD_USES(red)}, .run = note, .user = "s"});
            add(&f, (kd_system_desc){.name = "l",
                                     .phase = KD_PHASE_CULL,
                                     .components = {KD_CHANGES(red)},
                                     .run = note,
                                     .user = "l"});
            kd_schedule_randomize(f.schedule, seed);
            assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
            assert_int_equal(trace_length, 6);
            assert_true(strchr(trace, 'r') < strchr(trace, 's'));
            assert_int_equal(trace[5], 'l');
            assert_int_equal(wrong_worker, 0);
            if (again)
                assert_string_equal(trace, first); /* the seed alone decides */
            changes += strcmp(trace, first) != 0;
            strcpy(first, trace);
            destroy(&f);
        }
    }
    assert_true(changes > 10); /* of 40 from one seed to the next; a fixed order would give 1 */
}

static bool never(kd_system_context *c)
{
    (void)c;
    return false;
}

static void skipped_systems_still_release_their_successors(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        fixture f = make(thread_counts[t]);
        add(&f, (kd_system_desc){.name = "a", .components = {KD_CHANGES(red)}, .run = note, .user = "a"});
        add(&f, (kd_system_desc){
                    .name = "b", .components = {KD_CHANGES(red)}, .run = note, .user = "b", .run_if = never});
        add(&f, (kd_system_desc){.name = "c", .components = {KD_CHANGES(red)}, .run = note, .user = "c"});
        add(&f, (kd_system_desc){.name = "d", .components = {KD_CHANGES(red)}, .run = note, .user = "d"});
        kd_log_set_sink(quiet, NULL);
        assert_int_equal(kd_schedule_enable(f.schedule, "c", false), KD_OK);
        assert_int_equal(kd_schedule_enable(f.schedule, "none", false), KD_NOT_FOUND);
        kd_log_set_sink(NULL, NULL);
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
        assert_string_equal(trace, "ad");
        assert_int_equal(kd_schedule_enable(f.schedule, "c", true), KD_OK);
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
        assert_string_equal(trace, "adacd");
        destroy(&f);
    }
}

static kd_status init_ok(kd_system_context *c)
{
    note_on_lane(c);
    return KD_OK;
}

static kd_status init_bad(kd_system_context *c)
{
    (void)c;
    return KD_GPU;
}

static void init_runs_in_order_and_fini_in_reverse(void **state)
{
    (void)state;
    fixture f = make(2);
    static char names[] = "a\0b\0c";
    for (int i = 0; i < 3; i++)
        add(&f, (kd_system_desc){.name = &names[i * 2],
                                 .phase = i == 0 ? KD_PHASE_VIEW : KD_PHASE_INPUT,
                                 .run = note,
                                 .init = init_ok,
                                 .fini = note,
                                 .user = &names[i * 2]});
    assert_int_equal(kd_schedule_init(f.schedule), KD_OK);
    assert_string_equal(trace, "abc");
    clear_trace();
    destroy(&f);
    assert_string_equal(trace, "cba");
}

static void failed_init_stops_and_undoes_only_what_was_done(void **state)
{
    (void)state;
    fixture f = make(2);
    add(&f, (kd_system_desc){.name = "a", .run = note, .init = init_ok, .fini = note, .user = "a"});
    add(&f, (kd_system_desc){.name = "b", .run = note, .init = init_bad, .fini = note, .user = "b"});
    add(&f, (kd_system_desc){.name = "c", .run = note, .init = init_ok, .fini = note, .user = "c"});
    assert_int_equal(kd_schedule_run(f.schedule), KD_GPU);
    assert_string_equal(trace, "a");
    clear_trace();
    destroy(&f);
    assert_string_equal(trace, "a");
}

static void use_scratch(kd_system_context *c)
{
    memset(kd_arena_alloc(c->scratch, 1000), 1, 1000);
    assert_true(c->scratch->used_bytes <
                3000); /* two systems a frame at most, rounded up: emptied every frame */
}

static atomic_int begun, ended;

static void count_begin(void *user, uint32_t system, uint32_t worker)
{
    (void)user;
    (void)system;
    (void)worker;
    begun++;
}

static void count_end(void *user, uint32_t system, uint32_t worker)
{
    (void)user;
    (void)system;
    (void)worker;
    ended++;
}

static uint64_t bytes_of_user(const kd_system_context *c)
{
    return *(const uint64_t *)c->user;
}

static void hooks_and_scratch_serve_each_run(void **state)
{
    (void)state;
    fixture f = make(2);
    begun = ended = 0;
    uint64_t bytes = 123;
    add(&f, (kd_system_desc){.name = "a",
                             .components = {KD_USES(red)},
                             .run = use_scratch,
                             .bytes_moved = bytes_of_user,
                             .user = &bytes});
    add(&f, (kd_system_desc){.name = "b", .where = KD_ON_GPU, .run = use_scratch});
    add(&f, (kd_system_desc){.name = "c", .run = use_scratch, .run_if = never});
    kd_schedule_set_hooks(f.schedule, &(kd_schedule_hooks){.begin = count_begin, .end = count_end});
    for (int frame = 0; frame < 10; frame++)
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_int_equal(kd_schedule_bytes_moved(f.schedule, 0), 123);
    assert_int_equal(kd_schedule_bytes_moved(f.schedule, 1), 0);
    assert_int_equal(begun, 20);
    assert_int_equal(ended, 20);
    destroy(&f);
}

static void add_refuses_descriptions_that_make_no_sense(void **state)
{
    (void)state;
    fixture f = make(1);
    add(&f, (kd_system_desc){.name = "first", .run = note, .user = "f"});
    const kd_system_desc wrong[] = {
        {.run = note},
        {.name = "no function"},
        {.name = "no phase", .run = note, .phase = KD_PHASE_COUNT},
        {.name = "backwards", .run = note, .rate = {.every_s = -1}},
        {.name = "two rates", .run = note, .rate = {.every_s = 1, .every_frames = 2}},
        {.name = "never", .run = note, .rate = {.every_frames = 2, .offset_frames = 2}},
    };
    kd_log_set_sink(quiet, NULL);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(kd_schedule_add(f.schedule, &wrong[i]), KD_USAGE);
    assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_int_equal(kd_schedule_add(f.schedule, &(kd_system_desc){.name = "late", .run = note}), KD_USAGE);
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(kd_schedule_count(f.schedule), 1);
    destroy(&f);
}

static void systems_of_one_name_are_switched_together(void **state)
{
    (void)state;
    fixture f = make(1);
    clear_trace();
    for (int i = 0; i < 2; i++)
        add(&f, (kd_system_desc){.name = "twin", .run = note, .user = "t"});
    assert_int_equal(kd_schedule_enable(f.schedule, "twin", false), KD_OK);
    assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_string_equal(trace, "");
    destroy(&f);
}

static void add_refuses_more_systems_than_fit(void **state)
{
    (void)state;
    fixture f = make(1);
    for (int i = 0; i < 256; i++)
        add(&f, (kd_system_desc){.name = "s",
                                 .phase = (kd_phase)(i % KD_PHASE_COUNT),
                                 .components = {KD_CHANGES(red)},
                                 .run = note,
                                 .user = "s"});
    kd_log_set_sink(quiet, NULL);
    assert_int_equal(kd_schedule_add(f.schedule, &(kd_system_desc){.name = "s", .run = note}),
                     KD_OUT_OF_RANGE);
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(kd_schedule_count(f.schedule), 256);
    assert_string_equal(kd_schedule_system(f.schedule, 255)->name, "s");
    trace_length = -1000; /* not to overflow the trace */
    kd_schedule_enable(f.schedule, "s", false);
    destroy(&f);
}

/* r -> s -> t conflict in a row: the edge r -> t is implied and not drawn. */
static void dot_shows_phases_edges_and_barriers(void **state)
{
    (void)state;
    fixture f = make(1);
    char path[] = "/tmp/kandil_dot_XXXXXX";
    close(mkstemp(path));
    add(&f, (kd_system_desc){.name = "r\"",
                             .where = KD_ON_GPU,
                             .phase = KD_PHASE_SVO_BUILD,
                             .resources = {{"svo.nodes", KD_USE_STORAGE_WRITE}},
                             .run = note,
                             .user = "r"});
    add(&f, (kd_system_desc){.name = "s",
                             .where = KD_ON_GPU,
                             .phase = KD_PHASE_GATHER,
                             .resources = {{"svo.nodes", KD_USE_SAMPLED}, {"picture", KD_USE_TARGET}},
                             .run = note,
                             .user = "s"});
    add(&f, (kd_system_desc){.name = "t",
                             .where = KD_ON_GPU,
                             .phase = KD_PHASE_VIEW,
                             .resources = {{"svo.nodes", KD_USE_SAMPLED}, {"picture", KD_USE_SAMPLED}},
                             .run = note,
                             .user = "t"});
    add(&f, (kd_system_desc){.name = "u",
                             .phase = KD_PHASE_CAPTURE,
                             .rate = {.every_s = 0.5},
                             .run = note,
                             .run_if = never,
                             .user = "u"});
    add(&f, (kd_system_desc){.name = "v",
                             .phase = KD_PHASE_CAPTURE,
                             .rate = {.every_frames = 4, .offset_frames = 3},
                             .run = note,
                             .user = "v"});
    assert_int_equal(kd_schedule_enable(f.schedule, "v", false), KD_OK);
    kd_log_set_sink(quiet, NULL);
    assert_int_equal(kd_schedule_write_dot(f.schedule, path), KD_USAGE);
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_int_equal(kd_schedule_write_dot(f.schedule, path), KD_OK);
    void *text;
    size_t size;
    assert_int_equal(kd_file_read(path, KD_FILE_NO_LIMIT, &text, &size), KD_OK);
    assert_non_null(strstr(text, "subgraph cluster_gather"));
    assert_non_null(
        strstr(text, "label=\"r\\\"\\nbarrier: storage_write\"")); /* last frame's samples come first */
    assert_non_null(strstr(text, "label=\"s\\nbarrier: sampled\""));
    assert_non_null(strstr(text, "n0 -> n1 [label=\"sampled\"]"));
    assert_non_null(strstr(text, "n1 -> n2;"));
    assert_null(strstr(text, "n0 -> n2"));
    assert_non_null(strstr(text, "label=\"u\\nevery 0.5 s\\nif its condition holds\""));
    assert_non_null(strstr(text, "label=\"v\\nevery 4 frames from 3 on\", shape=ellipse, "
                                 "fillcolor=\"#f8f0dc\", style=\"filled,dashed\"]"));
    assert_null(strstr(text, "cluster_hierarchy"));
    free(text);
    unlink(path);
    destroy(&f);
}

static void a_system_that_is_not_there_gives_nothing(void **state)
{
    (void)state;
    fixture f = make(1);
    for (uint32_t index = 0; index < 100000; index += 33333) {
        assert_null(kd_schedule_system(f.schedule, index));
        kd_system_statistics counts = kd_schedule_statistics(f.schedule, index);
        assert_true(!counts.runs && !counts.rows && counts.median_ms == 0);
        assert_true(kd_schedule_bytes_moved(f.schedule, index) == 0);
    }
    destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(conflicting_systems_run_by_phase_then_registration),
        cmocka_unit_test(systems_conflict_over_two_descriptions_of_a_component),
        cmocka_unit_test(readers_run_between_their_writers),
        cmocka_unit_test(independent_systems_run_at_the_same_time),
        cmocka_unit_test(exclusive_system_separates_all_others),
        cmocka_unit_test(gpu_systems_keep_their_order_on_the_lane),
        cmocka_unit_test(commands_are_merged_at_the_phase_border),
        cmocka_unit_test(world_is_equal_at_any_thread_count_and_order),
        cmocka_unit_test(randomize_shuffles_only_what_is_free),
        cmocka_unit_test(skipped_systems_still_release_their_successors),
        cmocka_unit_test(init_runs_in_order_and_fini_in_reverse),
        cmocka_unit_test(failed_init_stops_and_undoes_only_what_was_done),
        cmocka_unit_test(hooks_and_scratch_serve_each_run),
        cmocka_unit_test(add_refuses_descriptions_that_make_no_sense),
        cmocka_unit_test(systems_of_one_name_are_switched_together),
        cmocka_unit_test(add_refuses_more_systems_than_fit),
        cmocka_unit_test(dot_shows_phases_edges_and_barriers),
        cmocka_unit_test(a_system_that_is_not_there_gives_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
