/* The profile as a table for people and as JSON for programs. */
#include <string.h>

#include "runtime/core/json.h"
#include "runtime/profile/internal.h"
#include "runtime/profile/profile.h"

static int name_width(const kd_profile *p)
{
    size_t width = strlen("system");
    for (uint32_t i = 0; i < kd_profile_system_count(p); i++) {
        size_t length = strlen(kd_profile_system_at(p, i).name);
        width = length > width ? length : width;
    }
    return (int)width;
}

static uint64_t skipped(const kd_profile_counts *c)
{
    return c->disabled + c->not_due + c->refused;
}

/* The share is of the sum over all frames: what runs once in a hundred frames counts as much as it costs. A
 * GPU system and a CPU system may run at the same time, so shares can add up to more than 100. */
static void write_row(FILE *out, int width, const kd_profile_system *system, const kd_profile_stats *stats,
                      double all_frames_ms)
{
    fprintf(out, "%-*s  %-15s  %-5s  %9.3f  %9.3f  %9.3f  %5.1f %%  %8.2f  %6llu  %7llu  %9llu\n", width,
            system->name, system->phase, system->gpu ? "gpu" : "cpu", stats->median_ms, stats->p95_ms,
            stats->max_ms, all_frames_ms > 0 ? 100 * stats->total_ms / all_frames_ms : 0.0,
            (double)stats->bytes * 1e-6, (unsigned long long)stats->runs,
            (unsigned long long)skipped(&stats->counts), (unsigned long long)stats->counts.rows);
}

/* Systems that never ran, each with the reason of most frames. */
static void write_idle(const kd_profile *p, FILE *out)
{
    const char *between = "did not run: ";
    for (uint32_t i = 0; i < kd_profile_system_count(p); i++) {
        kd_profile_counts c = kd_profile_system_stats(p, i).counts;
        if (c.runs || !skipped(&c))
            continue;
        fprintf(out, "%s%s (%s)", between, kd_profile_system_at(p, i).name,
                c.disabled >= c.not_due && c.disabled >= c.refused ? "disabled"
                : c.not_due >= c.refused                           ? "rate"
                                                                   : "condition");
        between = ", ";
    }
    if (between[0] == ',')
        fputc('\n', out);
}

static void write_allocations(const kd_profile *p, FILE *out)
{
    const kd_profile_allocations a = kd_profile_get_allocations(p);
    if (a.frames)
        fprintf(out, "allocations: none in %llu of %llu frames; %llu, %.2f MB, in the last; at most %llu, %.2f MB\n",
                (unsigned long long)a.frames_without, (unsigned long long)a.frames, (unsigned long long)a.last,
                (double)a.last_bytes * 1e-6, (unsigned long long)a.most, (double)a.most_bytes * 1e-6);
}

void kd_profile_write_table(const kd_profile *p, FILE *out)
{
    int width = name_width(p);
    kd_profile_stats frame = kd_profile_frame_stats(p);
    fprintf(out, "%-*s  %-15s  %-5s  %9s  %9s  %9s  %7s  %8s  %6s  %7s  %9s\n", width, "system", "phase",
            "where", "median ms", "p95 ms", "max ms", "share", "MB moved", "runs", "skipped", "rows");
    for (uint32_t i = 0; i < kd_profile_system_count(p); i++) {
        kd_profile_system system = kd_profile_system_at(p, i);
        kd_profile_stats stats = kd_profile_system_stats(p, i);
        if (stats.runs)
            write_row(out, width, &system, &stats, frame.total_ms);
    }
    fprintf(out, "%-*s  %-15s  %-5s  %9.3f  %9.3f  %9.3f  %7s  %8.2f  %6llu  %7s  %9s\n", width, "frame", "",
            "", frame.median_ms, frame.p95_ms, frame.max_ms, "", (double)frame.bytes * 1e-6,
            (unsigned long long)frame.runs, "", "");
    write_idle(p, out);
    write_allocations(p, out);
    fprintf(out, "GPU systems by: %s\n", profile_clock(p));
}

static void write_times(kd_json *json, const kd_profile_stats *stats, const char *const keys[3])
{
    const double values[3] = {stats->median_ms, stats->p95_ms, stats->max_ms};
    for (int i = 0; i < 3; i++) {
        kd_json_key(json, keys[i]);
        kd_json_double(json, values[i]);
    }
}

typedef struct json_count {
    const char *key;
    uint64_t value;
} json_count;

static void write_numbers(kd_json *json, const json_count *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        kd_json_key(json, rows[i].key);
        kd_json_uint(json, rows[i].value);
    }
}

static void write_counts(kd_json *json, const kd_profile_counts *c)
{
    const json_count rows[] = {{"runs", c->runs},
                               {"disabled", c->disabled},
                               {"not_due", c->not_due},
                               {"refused", c->refused},
                               {"rows", c->rows}};
    write_numbers(json, rows, sizeof rows / sizeof *rows);
}

static void write_allocation_counts(kd_json *json, kd_profile_allocations a)
{
    const json_count rows[] = {{"frames", a.frames},         {"frames_without", a.frames_without},
                               {"last", a.last},             {"last_bytes", a.last_bytes},
                               {"most", a.most},             {"most_bytes", a.most_bytes}};
    if (!a.frames)
        return;
    kd_json_key(json, "allocations");
    kd_json_object_begin(json);
    write_numbers(json, rows, sizeof rows / sizeof *rows);
    kd_json_object_end(json);
}

static void write_system(kd_json *json, const kd_profile_system *system, const kd_profile_stats *stats)
{
    kd_json_object_begin(json);
    kd_json_key(json, "name");
    kd_json_string(json, system->name);
    kd_json_key(json, "phase");
    kd_json_string(json, system->phase);
    kd_json_key(json, "where");
    kd_json_string(json, system->gpu ? "gpu" : "cpu");
    write_times(json, stats, (const char *const[]){"median_ms", "p95_ms", "max_ms"});
    kd_json_key(json, "bytes");
    kd_json_uint(json, stats->bytes);
    write_counts(json, &stats->counts);
    kd_json_object_end(json);
}

void kd_profile_write_json(const kd_profile *p, kd_json *json)
{
    kd_profile_stats frame = kd_profile_frame_stats(p);
    kd_json_key(json, "frame_ms");
    kd_json_object_begin(json);
    write_times(json, &frame, (const char *const[]){"median", "p95", "max"});
    kd_json_object_end(json);
    write_allocation_counts(json, kd_profile_get_allocations(p));
    kd_json_key(json, "systems");
    kd_json_array_begin(json);
    for (uint32_t i = 0; i < kd_profile_system_count(p); i++) {
        kd_profile_system system = kd_profile_system_at(p, i);
        kd_profile_stats stats = kd_profile_system_stats(p, i);
        write_system(json, &system, &stats);
    }
    kd_json_array_end(json);
}
