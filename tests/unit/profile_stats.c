#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "runtime/core/json.h"
#include "runtime/jobs/jobs.h"
#include "runtime/profile/profile.h"

static const kd_profile_system systems[] = {
    {"animate", "animate", false}, {"svo_build", "svo_build", true}, {"never", "view", true}};

static kd_profile *make(void)
{
    kd_profile *p = kd_profile_make(systems, 3);
    assert_non_null(p);
    return p;
}

static void assert_near(double value, double expected)
{
    if (fabs(value - expected) > 1e-9 * (1 + fabs(expected)))
        fail_msg("%.12g is not %.12g", value, expected);
}

static void feed(kd_profile *p, uint32_t system, const double *ms, int count)
{
    for (int i = 0; i < count; i++)
        kd_profile_gpu(p, system, (uint64_t)(ms[i] * 1e6 + 0.5));
}

static void nothing_measured_gives_zeros(void **state)
{
    (void)state;
    kd_profile *p = make();
    kd_profile_stats stats = kd_profile_system_stats(p, 1);
    assert_true(stats.median_ms == 0 && stats.p95_ms == 0 && stats.max_ms == 0 && stats.runs == 0);
    assert_int_equal(kd_profile_frame_stats(p).runs, 0);
    kd_profile_destroy(p);
}

/* Odd: the middle one. Even: between the two in the middle. The 95th of 100 samples 1..100 is 95; of 10 it is
 * the last, since only all ten are at least 95 in 100; of 20 samples 1..20 the nineteenth. */
static void statistics_of_known_series(void **state)
{
    (void)state;
    kd_profile *p = make();
    feed(p, 1, (const double[]){5, 1, 3}, 3);
    assert_near(kd_profile_system_stats(p, 1).median_ms, 3);
    assert_near(kd_profile_system_stats(p, 1).p95_ms, 5);
    feed(p, 1, (const double[]){2}, 1);
    kd_profile_stats stats = kd_profile_system_stats(p, 1);
    assert_near(stats.median_ms, 2.5);
    assert_near(stats.max_ms, 5);
    assert_near(stats.total_ms, 11);
    assert_int_equal(stats.runs, 4);
    kd_profile_destroy(p);

    static const struct {
        int n;
        double median, p95;
    } cases[] = {{1, 1, 1}, {10, 5.5, 10}, {20, 10.5, 19}, {21, 11, 20}, {100, 50.5, 95}, {1000, 500.5, 950}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        p = make();
        for (int i = cases[c].n; i >= 1; i--)
            feed(p, 1, &(double){i}, 1);
        stats = kd_profile_system_stats(p, 1);
        assert_near(stats.median_ms, cases[c].median);
        assert_near(stats.p95_ms, cases[c].p95);
        assert_near(stats.max_ms, cases[c].n);
        kd_profile_destroy(p);
    }
}

/* More samples than are kept: median of the latest 65536, maximum and sum of all. 70000 samples i = 0..69999
 * us: kept are 4464..69999, their median (4464 + 69999) / 2 = 37231.5 us. */
static void a_long_run_keeps_the_latest_samples(void **state)
{
    (void)state;
    kd_profile *p = make();
    kd_profile_gpu(p, 1, 1000000000);
    for (uint64_t i = 0; i < 70000; i++)
        kd_profile_gpu(p, 1, i * 1000);
    kd_profile_stats stats = kd_profile_system_stats(p, 1);
    assert_near(stats.median_ms, 37.2315);
    assert_near(stats.max_ms, 1000);
    assert_int_equal(stats.runs, 70001);
    assert_near(stats.total_ms, 1000 + 69999.0 * 35.0);
    kd_profile_destroy(p);
}

static void sleep_ms(long ms)
{
    nanosleep(&(struct timespec){.tv_nsec = ms * 1000000}, NULL);
}

/* A sleep lasts at least as long as asked for; upper bounds would depend on the machine, so only sums are
 * compared. */
static void cpu_time_is_the_systems_own(void **state)
{
    (void)state;
    kd_profile *p = make();
    for (int frame = 0; frame < 3; frame++) {
        kd_profile_frame_begin(p);
        kd_profile_begin(p, 0, 0);
        sleep_ms(2);
        kd_profile_begin(p, 1, 0); /* worker 0 helps with another system meanwhile */
        sleep_ms(8);
        kd_profile_end(p, 1, 0);
        kd_profile_end(p, 0, 0);
        kd_profile_frame_end(p);
    }
    kd_profile_stats outer = kd_profile_system_stats(p, 0), inner = kd_profile_system_stats(p, 1);
    kd_profile_stats frame = kd_profile_frame_stats(p);
    assert_int_equal(outer.runs, 3);
    assert_int_equal(inner.runs, 3);
    assert_int_equal(frame.runs, 3);
    assert_true(outer.total_ms >= 6 && inner.total_ms >= 24);
    assert_true(outer.total_ms + inner.total_ms <= frame.total_ms); /* nothing counted twice */
    kd_profile_destroy(p);
}

static void skipped_systems_have_no_sample(void **state)
{
    (void)state;
    kd_profile *p = make();
    for (int frame = 0; frame < 10; frame++) {
        kd_profile_frame_begin(p);
        if (frame % 5 == 0) {
            kd_profile_begin(p, 0, 3);
            kd_profile_end(p, 0, 3);
        }
        kd_profile_frame_end(p);
    }
    assert_int_equal(kd_profile_system_stats(p, 0).runs, 2);
    assert_int_equal(kd_profile_frame_stats(p).runs, 10);
    kd_profile_destroy(p);
}

static void gpu_times_replace_the_cost_of_recording(void **state)
{
    (void)state;
    kd_profile *p = make();
    kd_profile_frame_begin(p);
    kd_profile_begin(p, 1, 0);
    kd_profile_end(p, 1, 0);
    kd_profile_frame_end(p);
    kd_profile_gpu(p, 1, 7000000);
    assert_near(kd_profile_system_stats(p, 1).median_ms, 7);
    kd_profile_destroy(p);
}

typedef struct zone_job {
    kd_profile *profile;
    uint32_t system;
} zone_job;

static void run_zone(void *user, uint32_t worker)
{
    zone_job *job = user;
    kd_profile_begin(job->profile, job->system, worker);
    kd_profile_end(job->profile, job->system, worker);
}

static void zones_may_run_on_several_workers(void **state)
{
    (void)state;
    enum { SYSTEMS = 50, FRAMES = 200 };
    kd_profile_system many[SYSTEMS];
    for (int i = 0; i < SYSTEMS; i++)
        many[i] = (kd_profile_system){"s", "cull", false};
    kd_profile *p = kd_profile_make(many, SYSTEMS);
    kd_jobs *jobs = kd_jobs_make(3);
    static zone_job zones[SYSTEMS];
    for (int frame = 0; frame < FRAMES; frame++) {
        kd_profile_frame_begin(p);
        kd_job_counter counter = {0};
        for (uint32_t i = 0; i < SYSTEMS; i++) {
            zones[i] = (zone_job){p, i};
            kd_jobs_run(jobs, run_zone, &zones[i], &counter);
        }
        kd_jobs_wait(jobs, &counter);
        kd_profile_frame_end(p);
    }
    for (uint32_t i = 0; i < SYSTEMS; i++)
        assert_int_equal(kd_profile_system_stats(p, i).runs, FRAMES);
    kd_jobs_destroy(jobs);
    kd_profile_destroy(p);
}

static void json_has_the_members_of_the_statistics_file(void **state)
{
    (void)state;
    kd_profile *p = make();
    feed(p, 1, (const double[]){2, 4, 3}, 3);
    kd_profile_bytes(p, 1, 123456);
    kd_profile_count(p, 1, &(kd_profile_counts){3, 1, 2, 4, 500});
    kd_json json = {0};
    kd_json_object_begin(&json);
    kd_profile_write_json(p, &json);
    kd_json_object_end(&json);
    assert_string_equal(
        kd_json_text(&json),
        "{\"frame_ms\":{\"median\":0,\"p95\":0,\"max\":0},\"systems\":["
        "{\"name\":\"animate\",\"phase\":\"animate\",\"where\":\"cpu\",\"median_ms\":0,\"p95_ms\":0,"
        "\"max_ms\":0,\"bytes\":0,\"runs\":0,\"disabled\":0,\"not_due\":0,\"refused\":0,\"rows\":0},"
        "{\"name\":\"svo_build\",\"phase\":\"svo_build\",\"where\":\"gpu\",\"median_ms\":3,\"p95_ms\":4,"
        "\"max_ms\":4,\"bytes\":123456,\"runs\":3,\"disabled\":1,\"not_due\":2,\"refused\":4,\"rows\":500},"
        "{\"name\":\"never\",\"phase\":\"view\",\"where\":\"gpu\",\"median_ms\":0,\"p95_ms\":0,"
        "\"max_ms\":0,\"bytes\":0,\"runs\":0,\"disabled\":0,\"not_due\":0,\"refused\":0,\"rows\":0}]}");
    kd_json_fini(&json);
    kd_profile_destroy(p);
}

static void table_shows_what_ran_in_equal_columns(void **state)
{
    (void)state;
    kd_profile *p = make();
    feed(p, 1, (const double[]){2, 4, 3}, 3);
    kd_profile_bytes(p, 1, 1500000);
    kd_profile_count(p, 1, &(kd_profile_counts){3, 1, 2, 4, 777});
    kd_profile_frame_begin(p);
    kd_profile_frame_end(p);
    kd_profile_set_clock(p, "timestamps");
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    kd_profile_write_table(p, out);
    fclose(out);
    assert_non_null(strstr(text, "median ms"));
    const char *row = strstr(text, "svo_build");
    assert_non_null(row);
    assert_non_null(strstr(row, "3.000      4.000      4.000"));
    assert_non_null(strstr(row, "1.50"));
    assert_null(strstr(text, "never"));
    assert_null(strstr(text, "animate"));
    assert_non_null(strstr(row, " 3        7        777\n"));
    assert_non_null(strstr(text, "timestamps"));
    size_t heading = strcspn(text, "\n");
    const char *frame = strstr(text, "\nframe") + 1;
    assert_int_equal(strcspn(frame, "\n"), heading);
    free(text);
    kd_profile_destroy(p);
}

static void table_names_what_never_ran_and_why(void **state)
{
    (void)state;
    kd_profile *p = make();
    char *text = NULL;
    size_t size = 0;
    kd_profile_count(p, 0, &(kd_profile_counts){.disabled = 1, .refused = 9});
    kd_profile_count(p, 1, &(kd_profile_counts){.runs = 1, .not_due = 9});
    kd_profile_count(p, 2, &(kd_profile_counts){.disabled = 10});
    FILE *out = open_memstream(&text, &size);
    kd_profile_write_table(p, out);
    fclose(out);
    assert_non_null(strstr(text, "did not run: animate (condition), never (disabled)\n"));
    free(text);
    kd_profile_destroy(p);
}

static void allocations_are_told_by_frame(void **state)
{
    const kd_profile_system system = {"draw", "cull", false};
    kd_profile *p = kd_profile_make(&system, 1);
    (void)state;
    assert_int_equal(kd_profile_get_allocations(p).frames, 0);
    kd_profile_allocated(p, 7, 100);
    kd_profile_allocated(p, 0, 0);
    kd_profile_allocated(p, 2, 300);
    const kd_profile_allocations a = kd_profile_get_allocations(p);
    assert_true(a.frames == 3 && a.frames_without == 1);
    assert_true(a.most == 7 && a.most_bytes == 300);
    assert_true(a.last == 2 && a.last_bytes == 300);
    kd_profile_destroy(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_measured_gives_zeros),
        cmocka_unit_test(statistics_of_known_series),
        cmocka_unit_test(a_long_run_keeps_the_latest_samples),
        cmocka_unit_test(cpu_time_is_the_systems_own),
        cmocka_unit_test(skipped_systems_have_no_sample),
        cmocka_unit_test(gpu_times_replace_the_cost_of_recording),
        cmocka_unit_test(zones_may_run_on_several_workers),
        cmocka_unit_test(allocations_are_told_by_frame),
        cmocka_unit_test(json_has_the_members_of_the_statistics_file),
        cmocka_unit_test(table_shows_what_ran_in_equal_columns),
        cmocka_unit_test(table_names_what_never_ran_and_why),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
