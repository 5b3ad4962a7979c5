/* Which frames a system runs in, how often, with which time; what the statistics say about it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

typedef struct tally {
    uint32_t value;
} tally;
KD_COMPONENT_DEFINE(tally, "tally", KD_FIELD(tally, value, KD_U32, NULL, "a number"));

/* What a system saw: how often it ran in each frame, and the times of its last run. */
typedef struct seen {
    char runs[64];
    double time_s, dt_s, total_s;
} seen;

static void note(kd_system_context *c)
{
    seen *to = c->user;
    to->runs[c->frame] = (char)(to->runs[c->frame] ? to->runs[c->frame] + 1 : '1');
    to->time_s = c->time_s;
    to->dt_s = c->dt_s;
    to->total_s += c->dt_s;
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
    return f;
}

static void destroy(fixture *f)
{
    kd_schedule_destroy(f->schedule);
    kd_jobs_destroy(f->jobs);
    kd_world_destroy(f->world);
}

static void add(fixture *f, const char *name, kd_system_rate rate, seen *to)
{
    assert_int_equal(
        kd_schedule_add(f->schedule, &(kd_system_desc){.name = name, .rate = rate, .run = note, .user = to}),
        KD_OK);
}

/* Run frames; those in which a system did not run show as '.'. */
static void run(fixture *f, seen *to, uint32_t from, uint32_t count)
{
    for (uint32_t i = from; i < from + count; i++) {
        assert_int_equal(kd_schedule_run(f->schedule), KD_OK);
        if (!to->runs[i])
            to->runs[i] = '.';
    }
}

/* Steps of 1/4 s: exact in binary, so that the frames follow by hand. */
static void fixed_rate_runs_in_the_frames_that_reach_its_step(void **state)
{
    (void)state;
    static const struct {
        double every_s;
        uint32_t max_runs;
        const char *expected;
        double time_s;
        uint64_t dropped;
    } cases[] = {
        {0.25, 0, "11111111", 2.0, 0},        {0.5, 0, ".1.1.1.1", 2.0, 0}, {0.75, 0, "..1..1..", 1.5, 0},
        {0.125, 0, "22222222", 2.0, 0},       {0.1, 0, "23232323", 2.0, 0}, {0.0625, 3, "33333333", 2.0, 8},
        {0.01, 0, "88888888", 2.0, 200 - 64},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fixture f = make(2);
        seen to = {0};
        add(&f, "fixed", (kd_system_rate){.every_s = cases[i].every_s, .max_runs = cases[i].max_runs}, &to);
        kd_schedule_set_step(f.schedule, 0.25);
        run(&f, &to, 0, 8);
        assert_string_equal(to.runs, cases[i].expected);
        assert_true(to.dt_s == cases[i].every_s);
        assert_true(to.time_s > cases[i].time_s - 1e-9 && to.time_s < cases[i].time_s + 1e-9);
        assert_int_equal(kd_schedule_statistics(f.schedule, 0).dropped, cases[i].dropped);
        destroy(&f);
    }
}

/* 1/30 and 1/60 have no end in binary; a second must still be a second for an hour. */
static void rounding_never_shifts_a_step(void **state)
{
    (void)state;
    static const int rates[] = {24, 30, 60, 90};
    for (int r = 0; r < 4; r++) {
        fixture f = make(1);
        seen to = {0};
        add(&f, "second", (kd_system_rate){.every_s = 1}, &to);
        kd_schedule_set_step(f.schedule, 1.0 / rates[r]);
        uint64_t before = 0;
        for (int frame = 0; frame < 3600 * rates[r]; frame++) {
            kd_singleton(f.world, kd_schedule_clock)->frame = 0; /* `runs` is short */
            memset(to.runs, 0, sizeof to.runs);
            assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
            uint64_t runs = kd_schedule_statistics(f.schedule, 0).runs;
            assert_int_equal(runs - before, (frame + 1) % rates[r] == 0);
            before = runs;
        }
        destroy(&f);
    }
}

static void variable_rate_runs_every_nth_frame_from_its_offset(void **state)
{
    (void)state;
    fixture f = make(2);
    seen a = {0}, b = {0}, c = {0};
    add(&f, "a", (kd_system_rate){.every_frames = 3}, &a);
    add(&f, "b", (kd_system_rate){.every_frames = 3, .offset_frames = 2}, &b);
    add(&f, "c", (kd_system_rate){0}, &c);
    kd_schedule_set_step(f.schedule, 0.5);
    for (uint32_t i = 0; i < 7; i++) {
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
        a.runs[i] = a.runs[i] ? a.runs[i] : '.';
        b.runs[i] = b.runs[i] ? b.runs[i] : '.';
    }
    assert_string_equal(a.runs, "1..1..1");
    assert_string_equal(b.runs, "..1..1.");
    assert_string_equal(c.runs, "1111111");
    assert_true(a.dt_s == 1.5 && b.dt_s == 1.5 && c.dt_s == 0.5);
    assert_true(a.time_s == 3 && b.time_s == 2.5 && c.time_s == 3); /* frames 6, 5 and 6 */
    destroy(&f);
}

static void disabled_time_is_not_made_up_for(void **state)
{
    (void)state;
    fixture f = make(1);
    seen to = {0};
    add(&f, "fixed", (kd_system_rate){.every_s = 0.5}, &to);
    kd_schedule_set_step(f.schedule, 0.25);
    run(&f, &to, 0, 2);
    assert_int_equal(kd_schedule_enable(f.schedule, "fixed", false), KD_OK);
    run(&f, &to, 2, 5);
    assert_int_equal(kd_schedule_enable(f.schedule, "fixed", true), KD_OK);
    run(&f, &to, 7, 3);
    assert_string_equal(to.runs,
                        ".1.....1.1"); /* frames 3 and 5 are gone; 7 and 9 are where they always were */
    destroy(&f);
}

/* ---- the world's clock ---- */

static void restored_world_goes_on_with_its_rates(void **state)
{
    (void)state;
    fixture f = make(2);
    seen to = {0};
    kd_snapshot snapshot = {0};
    add(&f, "fixed", (kd_system_rate){.every_s = 0.75}, &to);
    kd_schedule_set_step(f.schedule, 0.25);
    run(&f, &to, 0, 4);
    assert_int_equal(kd_snapshot_write(f.world, &snapshot), KD_OK);
    run(&f, &to, 4, 8);
    assert_string_equal(to.runs, "..1..1..1..1");

    assert_int_equal(kd_snapshot_restore(f.world, snapshot.data, snapshot.size), KD_OK);
    memset(to.runs + 4, 0, sizeof to.runs - 4);
    run(&f, &to, 4, 8);
    assert_string_equal(to.runs, "..1..1..1..1"); /* the same frames again */

    fixture other = make(1); /* and in another world, with another schedule */
    seen there = {0};
    add(&other, "fixed", (kd_system_rate){.every_s = 0.75}, &there);
    assert_int_equal(kd_snapshot_restore(other.world, snapshot.data, snapshot.size), KD_OK);
    memcpy(there.runs, "----", 4);
    run(&other, &there, 4, 8);
    assert_string_equal(there.runs, "----.1..1..1");
    destroy(&other);
    destroy(&f);
    kd_snapshot_fini(&snapshot);
}

static void spawn_one(kd_system_context *c)
{
    kd_commands_spawn(c->commands, &KD_VAL(tally, {c->frame}), 1);
}

static uint64_t checksum_of(uint32_t threads, uint64_t seed)
{
    static const kd_system_rate rates[] = {
        {0}, {.every_s = 0.1}, {.every_s = 0.007, .max_runs = 2}, {.every_frames = 4, .offset_frames = 3}};
    fixture f = make(threads);
    for (int i = 0; i < 4; i++)
        assert_int_equal(kd_schedule_add(f.schedule, &(kd_system_desc){.name = "spawn",
                                                                       .phase = (kd_phase)(i / 2),
                                                                       .components = {KD_CHANGES(tally)},
                                                                       .rate = rates[i],
                                                                       .run = spawn_one}),
                         KD_OK);
    kd_schedule_randomize(f.schedule, seed);
    for (int frame = 0; frame < 60; frame++)
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    uint64_t checksum = kd_world_checksum(f.world);
    /* 60 frames of 1/60 s: 60 + 10 + 2 a frame (1/60 s holds two or three steps of 7 ms) + 15 */
    assert_int_equal(kd_entity_count(f.world), 60 + 10 + 120 + 15);
    destroy(&f);
    return checksum;
}

static void rates_are_equal_at_any_thread_count(void **state)
{
    (void)state;
    uint64_t expected = checksum_of(1, 0);
    for (uint32_t threads = 1; threads <= 4; threads++)
        assert_true(checksum_of(threads, 0) == expected);
    for (uint64_t seed = 1; seed <= 5; seed++)
        assert_true(checksum_of(2, seed) == expected);
}

/* ---- statistics ---- */

static bool odd_frame(kd_system_context *c)
{
    return c->frame % 2 == 1;
}

static void walk(kd_system_context *c)
{
    kd_query *q = kd_query_make(c->world, &(kd_query_desc){.terms = {KD_READ(tally)}});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        assert_int_equal(KD_COLUMN(&it, tally, 0)->value, 0);
    kd_query_destroy(q);
    uint64_t until = kd_clock_ns() + 100000;
    while (kd_clock_ns() < until)
        ;
}

static void statistics_tell_runs_and_why_there_were_none(void **state)
{
    (void)state;
    fixture f = make(2);
    for (int i = 0; i < 30; i++)
        kd_spawn(f.world, KD_VAL(tally, {0}));
    assert_int_equal(kd_schedule_add(f.schedule, &(kd_system_desc){.name = "walk",
                                                                   .components = {KD_USES(tally)},
                                                                   .rate = {.every_frames = 3},
                                                                   .run_if = odd_frame,
                                                                   .run = walk}),
                     KD_OK);
    assert_int_equal(kd_schedule_run(f.schedule), KD_OK); /* 0: due, refused */
    assert_int_equal(kd_schedule_measure(f.schedule, true), KD_OK);
    for (int frame = 1; frame < 12; frame++) /* due 3, 6, 9; runs 3, 9 */
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    kd_schedule_enable(f.schedule, "walk", false);
    for (int frame = 12; frame < 17; frame++)
        assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    kd_system_statistics s = kd_schedule_statistics(f.schedule, 0);
    assert_int_equal(s.runs, 2);
    assert_int_equal(s.refused, 2);
    assert_int_equal(s.not_due, 8);
    assert_int_equal(s.disabled, 5);
    assert_int_equal(s.dropped, 0);
    assert_int_equal(s.rows, 60);
    assert_int_equal(s.tables, 2);
    assert_true(s.median_ms >= 0.1 && s.max_ms >= s.median_ms && s.total_ms >= 2 * 0.1);
    destroy(&f);
}

/* Rows with enough work for the loop to be cut, each of which records one spawn. */
static void split_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    const tally *t = KD_COLUMN(rows, tally, 0);
    const uint32_t *run = user;
    for (uint32_t i = 0; i < rows->count; i++) {
        uint32_t value = t[i].value + *run;
        for (int k = 0; k < 500; k++)
            value = value * 1664525u + 1013904223u;
        kd_commands_spawn(commands, (kd_value[]){KD_VAL(tally, {value})}, 1);
    }
}

static void loop_in_each_run(kd_system_context *c)
{
    uint32_t *run = c->user;
    kd_query *q = kd_query_make(c->world, &(kd_query_desc){.terms = {KD_READ(tally)}});
    ++*run;
    assert_int_equal(kd_query_parallel(q, c->jobs, c->command_key, split_rows, run), KD_OK);
    kd_commands_spawn(c->commands, (kd_value[]){KD_VAL(tally, {*run})}, 1);
    kd_query_destroy(q);
}

static uint64_t world_of_loops(uint32_t threads)
{
    fixture f = make(threads);
    uint32_t run = 0;
    for (uint32_t i = 0; i < 5000; i++)
        kd_spawn(f.world, KD_VAL(tally, {i}));
    assert_int_equal(kd_schedule_add(f.schedule, &(kd_system_desc){.name = "loops",
                                                                   .rate = {.every_s = 0.25},
                                                                   .components = {KD_CHANGES(tally)},
                                                                   .run = loop_in_each_run,
                                                                   .user = &run}),
                     KD_OK);
    kd_schedule_set_step(f.schedule, 0.5);
    assert_int_equal(kd_schedule_run(f.schedule), KD_OK);
    assert_int_equal(run, 2);
    uint64_t checksum = kd_world_checksum(f.world);
    destroy(&f);
    return checksum;
}

static void runs_of_one_frame_record_one_behind_the_other(void **state)
{
    (void)state;
    uint64_t alone = world_of_loops(1);
    for (uint32_t threads = 2; threads <= 4; threads++)
        assert_true(world_of_loops(threads) == alone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fixed_rate_runs_in_the_frames_that_reach_its_step),
        cmocka_unit_test(rounding_never_shifts_a_step),
        cmocka_unit_test(variable_rate_runs_every_nth_frame_from_its_offset),
        cmocka_unit_test(disabled_time_is_not_made_up_for),
        cmocka_unit_test(restored_world_goes_on_with_its_rates),
        cmocka_unit_test(rates_are_equal_at_any_thread_count),
        cmocka_unit_test(statistics_tell_runs_and_why_there_were_none),
        cmocka_unit_test(runs_of_one_frame_record_one_behind_the_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
