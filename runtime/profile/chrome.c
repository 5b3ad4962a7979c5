/* The timeline in Chrome's JSON, which chrome://tracing and Perfetto's viewer read, and beside it every
 * system's samples, by which a later run is compared.
 *
 *  Source  "Trace Event Format", the JSON object form: complete events X, counters C, metadata M;
 * microseconds */
#include <stdlib.h>

#include "runtime/core/file.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"
#include "runtime/profile/internal.h"

typedef struct writer {
    FILE *out;
    const kd_trace *trace;
    kd_json *names, *categories; /* [name count]: as JSON strings */
    bool comma;
} writer;

static void next(writer *w)
{
    fputs(w->comma ? ",\n" : "\n", w->out);
    w->comma = true;
}

static double us(const writer *w, uint64_t ns)
{
    uint64_t start = kd_trace_start_ns(w->trace);
    return ns > start ? (double)(ns - start) * 1e-3 : 0;
}

/* ---- names ---- */

static bool make_names(writer *w)
{
    uint32_t count = kd_trace_name_count(w->trace);
    bool ok = true;
    w->names = calloc(count, sizeof *w->names);
    w->categories = calloc(count, sizeof *w->categories);
    for (uint32_t i = 0; i < count && w->names && w->categories; i++) {
        const char *category, *text = kd_trace_name_text(w->trace, i, &category);
        kd_json_string(&w->names[i], text);
        kd_json_string(&w->categories[i], category);
        ok = ok && kd_json_text(&w->names[i]) && kd_json_text(&w->categories[i]);
    }
    return ok && w->names && w->categories;
}

static void free_names(writer *w)
{
    for (uint32_t i = 0; i < kd_trace_name_count(w->trace) && w->names && w->categories; i++) {
        kd_json_fini(&w->names[i]);
        kd_json_fini(&w->categories[i]);
    }
    free(w->names);
    free(w->categories);
}

/* ---- events ---- */

static void put_track_name(writer *w, uint32_t track, const char *name)
{
    kd_json text = {0};
    kd_json_string(&text, name);
    next(w);
    fprintf(w->out, "{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":1,\"tid\":%u,\"args\":{\"name\":%s}}",
            track + 1, kd_json_text(&text) ? kd_json_text(&text) : "\"\"");
    next(w);
    fprintf(w->out,
            "{\"name\":\"thread_sort_index\",\"ph\":\"M\",\"pid\":1,\"tid\":%u,\"args\":{\"sort_index\":%u}}",
            track + 1, track);
    kd_json_fini(&text);
}

static void put_tracks(writer *w)
{
    next(w);
    fprintf(w->out, "{\"name\":\"process_name\",\"ph\":\"M\",\"pid\":1,\"args\":{\"name\":\"kandil\"}}");
    for (uint32_t i = 0; i < kd_trace_track_count(w->trace); i++) {
        kd_trace_kind kind;
        const char *name = kd_trace_track_name(w->trace, i, &kind);
        if (name)
            put_track_name(w, i, name);
    }
}

static void put_zones(writer *w, uint32_t track)
{
    uint64_t count;
    const kd_trace_event *zones = kd_trace_events(w->trace, track, &count);
    for (uint64_t i = 0; i < count; i++) {
        next(w);
        fprintf(w->out, "{\"name\":%s,\"cat\":%s,\"ph\":\"X\",\"ts\":%.3f,\"dur\":%.3f,\"pid\":1,\"tid\":%u}",
                kd_json_text(&w->names[zones[i].name]), kd_json_text(&w->categories[zones[i].name]),
                us(w, zones[i].start_ns), (double)(zones[i].end_ns - zones[i].start_ns) * 1e-3, track + 1);
    }
}

static void put_values(writer *w)
{
    uint64_t count;
    const kd_trace_value *values = kd_trace_values(w->trace, &count);
    for (uint64_t i = 0; i < count; i++) {
        next(w);
        fprintf(w->out, "{\"name\":%s,\"ph\":\"C\",\"ts\":%.3f,\"pid\":1,\"args\":{\"value\":%.17g}}",
                kd_json_text(&w->names[values[i].name]), us(w, values[i].ns), values[i].value);
    }
}

/* ---- samples ---- */

static void put_samples(kd_json *j, const kd_profile *p, uint32_t system)
{
    profile_samples samples = profile_system_samples(p, system);
    kd_json_key(j, "samples_ms");
    kd_json_array_begin(j);
    for (uint64_t i = 0; i < samples.count; i++)
        kd_json_double(j, (double)samples.ns[(samples.first + i) % samples.count] * 1e-6);
    kd_json_array_end(j);
}

static void put_system(kd_json *j, const kd_profile *p, uint32_t index)
{
    kd_profile_system system = kd_profile_system_at(p, index);
    kd_json_object_begin(j);
    kd_json_key(j, "name");
    kd_json_string(j, system.name);
    kd_json_key(j, "phase");
    kd_json_string(j, system.phase);
    kd_json_key(j, "where");
    kd_json_string(j, system.gpu ? "gpu" : "cpu");
    put_samples(j, p, index);
    kd_json_object_end(j);
}

/* The object "kandil", which kd_profile_compare reads. */
static bool put_profile(writer *w, const kd_profile *p)
{
    kd_json j = {0};
    kd_json_object_begin(&j);
    kd_json_key(&j, "gpu_clock");
    kd_json_string(&j, profile_clock(p));
    kd_json_key(&j, "dropped");
    kd_json_uint(&j, kd_trace_dropped(w->trace));
    kd_json_key(&j, "frame");
    kd_json_object_begin(&j);
    put_samples(&j, p, kd_profile_system_count(p));
    kd_json_object_end(&j);
    kd_json_key(&j, "systems");
    kd_json_array_begin(&j);
    for (uint32_t i = 0; i < kd_profile_system_count(p); i++)
        put_system(&j, p, i);
    kd_json_array_end(&j);
    kd_json_object_end(&j);
    bool ok = kd_json_text(&j) != NULL;
    if (ok)
        fprintf(w->out, ",\n\"kandil\":%s", kd_json_text(&j));
    kd_json_fini(&j);
    return ok;
}

kd_status profile_write_chrome(const kd_profile *p, const kd_trace *trace, const char *path)
{
    kd_file_out file;
    kd_status status = kd_file_out_open(&file, path);
    if (status != KD_OK)
        return status;
    writer w = {.out = file.stream, .trace = trace};
    bool ok = make_names(&w);
    fputs("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[", w.out);
    if (ok) {
        put_tracks(&w);
        for (uint32_t i = 0; i < kd_trace_track_count(trace); i++)
            put_zones(&w, i);
        put_values(&w);
    }
    fputs("]", w.out);
    ok = ok && put_profile(&w, p);
    fputs("}\n", w.out);
    free_names(&w);
    if (ok)
        return kd_file_out_commit(&file);
    kd_file_out_cancel(&file);
    return kd_fail(KD_NO_MEMORY, "%s: out of memory", path);
}
