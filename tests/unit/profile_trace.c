/* The timeline: order and nesting, both file formats, the comparison of two runs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/profile/json_read.h"
#include "runtime/profile/profile.h"
#include "runtime/profile/trace.h"
#include "tests/pftrace.h"

static char message[512];

static void sink(void *user, kd_log_level level, const char *text)
{
    (void)user;
    if (level == KD_LOG_ERROR)
        snprintf(message, sizeof message, "%s", text);
}

static int set_up(void **state)
{
    kd_log_set_sink(sink, NULL);
    return open_folder(state);
}

static const kd_profile_system systems[] = {
    {"walk", "animate", false}, {"build", "svo_build", true}, {"odd \"name\"\n\xff", "view", false}};

/* ---- zones ---- */

static void zones_are_nested_by_time(void **state)
{
    (void)state;
    kd_trace *t = kd_trace_make(1 << 20, 1);
    kd_trace_name a = kd_trace_intern(t, "a", "x"), b = kd_trace_intern(t, "b", "x");
    assert_true(a != b && kd_trace_intern(t, "a", "x") == a);
    kd_trace_zone(t, 0, b, 150, 180); /* inside the one recorded later */
    kd_trace_zone(t, 0, a, 100, 200);
    kd_trace_zone(t, 0, b, 200, 310); /* sticks out of the one round it: clocks */
    kd_trace_zone(t, 0, a, 200, 300);
    kd_trace_zone(t, 0, b, 250, 305);
    kd_trace_begin(t, 0, a, 400);
    kd_trace_begin(t, 0, b, 400);
    kd_trace_end(t, 0, 500);
    kd_trace_end(t, 0, 500); /* equal: the one that ended last is outside */
    kd_trace_sort(t);
    static const struct {
        uint64_t start, end;
        int name;
        uint32_t depth;
    } wanted[] = {{100, 200, 0, 0}, {150, 180, 1, 1}, {200, 310, 1, 0}, {200, 300, 0, 1},
                  {250, 300, 1, 2}, {400, 500, 0, 0}, {400, 500, 1, 1}};
    uint64_t count;
    const kd_trace_event *e = kd_trace_events(t, 0, &count);
    assert_int_equal(count, 7);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(e[i].start_ns, wanted[i].start);
        assert_int_equal(e[i].end_ns, wanted[i].end);
        assert_int_equal(e[i].name, wanted[i].name ? b : a);
        assert_int_equal(e[i].depth, wanted[i].depth);
    }
    kd_trace_destroy(t);
}

static void a_full_trace_drops_and_counts(void **state)
{
    (void)state;
    kd_trace *t = kd_trace_make(4096, 1); /* half for zones: 85 of 24 bytes */
    for (uint64_t i = 0; i < 100; i++)
        kd_trace_zone(t, 0, 0, i, i + 1);
    uint64_t count;
    kd_trace_events(t, 0, &count);
    assert_true(count >= 80 && count < 100);
    assert_int_equal(kd_trace_dropped(t), 100 - count);
    for (uint32_t i = 0; i < 2 * KD_TRACE_MAX_DEPTH; i++)
        kd_trace_begin(t, 0, 0, i);
    for (uint32_t i = 0; i < 2 * KD_TRACE_MAX_DEPTH; i++)
        kd_trace_end(t, 0, 1000);
    kd_trace_sort(t);
    kd_trace_destroy(t);
}

/* ---- files ---- */

static kd_profile *recorded(void)
{
    kd_profile *p = kd_profile_make(systems, 3);
    assert_int_equal(kd_profile_trace(p, 2), KD_OK);
    uint32_t pass = kd_profile_pass_name(p, "build.scan"), voxels = kd_profile_counter_name(p, "voxels");
    for (int frame = 0; frame < 3; frame++) {
        kd_profile_frame_begin(p);
        kd_profile_begin(p, 0, 0);
        kd_profile_job_begin(p, 0, 1);
        kd_profile_job_end(p, 0, 1);
        kd_profile_end(p, 0, 0);
        kd_profile_job_begin(p, 1, 0);
        kd_profile_begin(p, 2, 1);
        kd_profile_end(p, 2, 1);
        kd_profile_job_end(p, 1, 0);
        kd_profile_gpu(p, 1, 1000);
        uint64_t ns = 1000000000000000ull + (uint64_t)frame * 10000;
        kd_profile_gpu_pass(p, pass, ns + 100, ns + 900);
        kd_profile_gpu_zone(p, 1, ns, ns + 1000);
        kd_profile_frame_end(p);
        kd_profile_counter(p, voxels, 12345.5);
    }
    return p;
}

static size_t count_zones(const pf_trace *t, const char *name)
{
    size_t count = 0;
    for (size_t i = 0; i < t->zone_count; i++)
        count += strcmp(t->zones[i].name, name) == 0;
    return count;
}

static void perfetto_files_decode_again(void **state)
{
    (void)state;
    kd_profile *p = recorded();
    assert_int_equal(kd_profile_write_trace(p, "a.pftrace"), KD_OK);
    pf_trace t = pf_decode("a.pftrace");
    if (t.mistake)
        fail_msg("%s", t.mistake);
    /* process, main, worker 1, GPU, counter */
    assert_int_equal(t.track_count, 5);
    assert_true(t.tracks[1].thread && strcmp(t.tracks[1].name, "main") == 0);
    assert_true(t.tracks[2].thread && strcmp(t.tracks[2].name, "worker 1") == 0);
    assert_true(!t.tracks[3].thread && strcmp(t.tracks[3].name, "GPU") == 0);
    assert_true(t.tracks[4].counter && strcmp(t.tracks[4].name, "voxels") == 0);
    for (uint32_t i = 1; i < 5; i++)
        assert_int_equal(t.tracks[i].parent, t.tracks[0].uuid);
    assert_int_equal(t.value_count, 3);
    static const char *const names[] = {"frame", "walk",       "walk (part)",       "job",
                                        "build", "build.scan", "odd \"name\"\n\xff"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        assert_int_equal(count_zones(&t, names[i]), 3);
    for (size_t i = 0; i < t.zone_count; i++) {
        const pf_zone *z = &t.zones[i];
        if (strcmp(z->name, "build.scan") == 0)
            assert_true(z->depth == 1 && z->end_ns - z->start_ns == 800);
        if (strcmp(z->name, "walk (part)") == 0)
            assert_int_equal(z->depth, 2);
    }
    free(t.zones);
    kd_profile_destroy(p);
}

static void chrome_files_read_again(void **state)
{
    (void)state;
    kd_profile *p = recorded();
    assert_int_equal(kd_profile_write_trace(p, "a.json"), KD_OK);
    void *data;
    size_t size;
    assert_int_equal(kd_file_read("a.json", KD_FILE_NO_LIMIT, &data, &size), KD_OK);
    json_reader r = {data, (const char *)data + size, false};
    char key[32], phase[8], name[64];
    uint32_t zones = 0, counters = 0, others = 0;
    for (json_begin(&r, '{'); json_next_key(&r, key, sizeof key);) {
        if (strcmp(key, "traceEvents") != 0) {
            json_skip(&r);
            continue;
        }
        for (json_begin(&r, '['); json_next_item(&r);) {
            double ts = -1, duration = -1;
            for (json_begin(&r, '{'); json_next_key(&r, key, sizeof key);) {
                if (strcmp(key, "ph") == 0)
                    json_string(&r, phase, sizeof phase);
                else if (strcmp(key, "name") == 0)
                    json_string(&r, name, sizeof name);
                else if (strcmp(key, "ts") == 0)
                    ts = json_number(&r);
                else if (strcmp(key, "dur") == 0)
                    duration = json_number(&r);
                else
                    json_skip(&r);
            }
            zones += phase[0] == 'X' && ts >= 0 && duration >= 0;
            counters += phase[0] == 'C' && ts >= 0;
            others += phase[0] == 'M';
        }
    }
    assert_false(r.failed);
    assert_true(r.at < r.end && *r.at == '\n');
    assert_int_equal(zones, 21);
    assert_int_equal(counters, 3);
    assert_int_equal(others, 7); /* a name for the process, two entries a track */
    free(data);
    kd_profile_destroy(p);
}

static void files_that_cannot_be_written_are_reported(void **state)
{
    (void)state;
    kd_profile *p = recorded();
    assert_int_equal(kd_profile_write_trace(p, "/dev/full"), KD_DISK_FULL);
    assert_int_equal(kd_profile_write_trace(p, "missing/a.pftrace"), KD_NOT_FOUND);
    kd_profile_destroy(p);
}

/* ---- comparing ---- */

/* A random walk round `ms`: neighbours resemble each other, as frames do. */
static kd_profile *run_of(const double ms[3], uint32_t frames, uint64_t seed)
{
    static const kd_profile_system plain[] = {
        {"walk", "animate", false}, {"build", "svo_build", true}, {"odd \"name\"", "view", false}};
    kd_profile *p = kd_profile_make(plain, 3);
    double drift[3] = {0};
    assert_int_equal(kd_profile_trace(p, 1), KD_OK);
    for (uint32_t f = 0; f < frames; f++) {
        kd_profile_frame_begin(p);
        kd_profile_frame_end(p);
        for (uint32_t i = 0; i < 3; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            double noise = (double)(seed >> 33) / 2147483648.0 - 0.5;
            drift[i] = 0.6 * drift[i] + noise;
            kd_profile_gpu(p, i, (uint64_t)(ms[i] * (1 + 0.05 * drift[i]) * 1e6));
        }
    }
    return p;
}

static const char *report_of(const double before[3], const double after[3], uint32_t frames, uint64_t seed)
{
    static char text[8192];
    kd_profile *old = run_of(before, frames, seed), *now = run_of(after, frames, seed + 77);
    assert_int_equal(kd_profile_write_trace(old, "old.json"), KD_OK);
    FILE *out = fopen("report", "w+");
    assert_int_equal(kd_profile_compare(now, "old.json", out), KD_OK);
    rewind(out);
    text[fread(text, 1, sizeof text - 1, out)] = '\0';
    fclose(out);
    kd_profile_destroy(old);
    kd_profile_destroy(now);
    return text;
}

static void a_slower_system_is_named(void **state)
{
    (void)state;
    const double before[3] = {5, 10, 2}, after[3] = {5, 12, 1.5};
    const char *text = report_of(before, after, 100, 1);
    assert_non_null(strstr(text, "slower: build\n"));
    assert_non_null(strstr(text, "faster"));
    /* With three systems the walk is the same, whatever its noise. */
    assert_non_null(strstr(text, "same"));
}

/* Equal runs: of 60 comparisons of three systems, fewer than 1 of 100 may call anything slower. */
static void noise_is_not_reported(void **state)
{
    (void)state;
    const double same[3] = {5, 10, 2};
    int reports = 0;
    for (uint64_t seed = 1; seed <= 60; seed++)
        reports += strstr(report_of(same, same, 60, seed), "slower: ") != NULL;
    assert_true(reports <= 1);
}

static void too_few_frames_are_not_judged(void **state)
{
    (void)state;
    const double before[3] = {5, 10, 2}, after[3] = {5, 20, 2};
    const char *text = report_of(before, after, 5, 1);
    assert_non_null(strstr(text, "too few frames"));
    assert_non_null(strstr(text, "nothing can be told"));
}

static void broken_profiles_are_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"",
                                        "{}",
                                        "[",
                                        "{\"kandil\":5}",
                                        "{\"kandil\":{\"systems\":[{\"samples_ms\":[1,}]}}",
                                        "{\"kandil\":{\"systems\":[{\"samples_ms\":[\"x\"]}]}}",
                                        "{\"traceEvents\":[[[[",
                                        "{\"traceEvents\":\"\\",
                                        "{\"a\":}]"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        assert_int_equal(kd_file_write("broken.json", texts[i], strlen(texts[i])), KD_OK);
        if (kd_profile_check_old("broken.json") != KD_BAD_FORMAT || !strstr(message, "is no profile; "))
            fail_msg("%s: %s", texts[i], message);
    }
    assert_int_equal(kd_profile_check_old("missing.json"), KD_NOT_FOUND);
    /* every truncated length of a real one */
    void *data;
    size_t size;
    kd_profile *p = recorded();
    assert_int_equal(kd_profile_write_trace(p, "whole.json"), KD_OK);
    assert_int_equal(kd_file_read("whole.json", KD_FILE_NO_LIMIT, &data, &size), KD_OK);
    for (size_t n = 0; n + 2 < size; n += 7) {
        assert_int_equal(kd_file_write("broken.json", data, n), KD_OK);
        assert_int_equal(kd_profile_check_old("broken.json"), KD_BAD_FORMAT);
    }
    free(data);
    kd_profile_destroy(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zones_are_nested_by_time),
        cmocka_unit_test(a_full_trace_drops_and_counts),
        cmocka_unit_test(perfetto_files_decode_again),
        cmocka_unit_test(chrome_files_read_again),
        cmocka_unit_test(files_that_cannot_be_written_are_reported),
        cmocka_unit_test(a_slower_system_is_named),
        cmocka_unit_test(noise_is_not_reported),
        cmocka_unit_test(too_few_frames_are_not_judged),
        cmocka_unit_test(broken_profiles_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, close_folder);
}
