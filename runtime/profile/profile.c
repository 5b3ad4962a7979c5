/* A series of samples for the frame and two for each system (CPU and GPU clock). Within a frame a system adds
 * to its own sum only; the frame's end, when nothing runs, turns sums into samples, so that no lock is needed
 * and buffers grow only there. */
#include "runtime/profile/profile.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/profile/internal.h"

enum { MAX_WORKERS = 64, FIRST_CAPACITY = 256 };

typedef struct series {
    uint64_t *ns; /* a ring once capacity has reached KD_PROFILE_SAMPLES */
    uint32_t capacity;
    uint64_t count; /* ever added; sample i lies at i % capacity */
    uint64_t max_ns, total_ns;
} series;

typedef struct system_zone {
    char *name;
    const char *phase;
    bool gpu;
    bool ran;          /* in this frame */
    uint64_t frame_ns; /* own time in this frame */
    uint64_t bytes;
    kd_profile_counts counts;
    /* while it runs */
    uint64_t start_ns, inner_ns;        /* inner: spent in zones that began inside this one */
    uint32_t outer;                     /* the zone round it on the same worker */
    kd_trace_name zone_name, part_name; /* of the system and of a share of its loops */
    series cpu_times, gpu_times;
} system_zone;

#define NO_ZONE UINT32_MAX

typedef struct worker_state {
    uint32_t current; /* zone, or NO_ZONE */
    char apart[60];   /* each in a cache line of its own */
} worker_state;

struct kd_profile {
    system_zone *zones;
    uint32_t zone_count;
    char clock[64];
    uint64_t frame_start_ns;
    series frame_times;
    kd_profile_allocations allocations;
    worker_state workers[MAX_WORKERS];
    kd_trace *trace; /* NULL: statistics alone */
    uint32_t gpu_track;
    kd_trace_name frame_name, job_name;
};

/* ---- series ---- */

static bool reserve(series *s)
{
    if (s->count < s->capacity || s->capacity == KD_PROFILE_SAMPLES)
        return true;
    uint32_t capacity = s->capacity ? s->capacity * 2 : FIRST_CAPACITY;
    uint64_t *ns = realloc(s->ns, capacity * sizeof *ns);
    if (!ns)
        return false;
    s->ns = ns;
    s->capacity = capacity;
    return true;
}

/* Without memory for more samples the ring keeps its size: the oldest are given up earlier. */
static void add_sample(series *s, uint64_t ns)
{
    if (!reserve(s) && s->capacity == 0)
        return;
    s->ns[s->count % s->capacity] = ns;
    s->count++;
    s->total_ns += ns;
    s->max_ns = ns > s->max_ns ? ns : s->max_ns;
}

static int compare_ns(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static kd_profile_stats summarize(const series *s)
{
    kd_profile_stats stats = {
        .max_ms = (double)s->max_ns * 1e-6, .total_ms = (double)s->total_ns * 1e-6, .runs = s->count};
    size_t n = s->count < s->capacity ? (size_t)s->count : s->capacity;
    uint64_t *sorted = n ? malloc(n * sizeof *sorted) : NULL;
    if (!sorted)
        return stats;
    memcpy(sorted, s->ns, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare_ns);
    stats.median_ms = ((double)sorted[(n - 1) / 2] + (double)sorted[n / 2]) * 0.5e-6;
    stats.min_ms = (double)sorted[0] * 1e-6;
    stats.p95_ms = (double)sorted[(n * 95 + 99) / 100 - 1] * 1e-6;
    free(sorted);
    return stats;
}

/* ---- making ---- */

kd_profile *kd_profile_make(const kd_profile_system *systems, uint32_t count)
{
    kd_profile *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    p->zones = calloc(count + 1, sizeof *p->zones);
    p->zone_count = p->zones ? count : 0;
    bool ok = p->zones && reserve(&p->frame_times);
    for (uint32_t i = 0; i < p->zone_count; i++) {
        p->zones[i] =
            (system_zone){.name = strdup(systems[i].name), .phase = systems[i].phase, .gpu = systems[i].gpu};
        ok = ok && p->zones[i].name && reserve(&p->zones[i].cpu_times) &&
             (!systems[i].gpu || reserve(&p->zones[i].gpu_times));
    }
    for (uint32_t i = 0; i < MAX_WORKERS; i++)
        p->workers[i].current = NO_ZONE;
    kd_profile_set_clock(p, "CPU clock of the recording");
    if (ok)
        return p;
    kd_profile_destroy(p);
    return NULL;
}

void kd_profile_destroy(kd_profile *p)
{
    if (!p)
        return;
    for (uint32_t i = 0; i < p->zone_count; i++) {
        free(p->zones[i].name);
        free(p->zones[i].cpu_times.ns);
        free(p->zones[i].gpu_times.ns);
    }
    kd_trace_destroy(p->trace);
    free(p->zones);
    free(p->frame_times.ns);
    free(p);
}

void kd_profile_set_clock(kd_profile *p, const char *text)
{
    snprintf(p->clock, sizeof p->clock, "%s", text);
}

/* ---- measuring ---- */

void kd_profile_frame_begin(kd_profile *p)
{
    p->frame_start_ns = kd_clock_ns();
    if (p->trace)
        kd_trace_begin(p->trace, 0, p->frame_name, p->frame_start_ns);
}

void kd_profile_frame_end(kd_profile *p)
{
    uint64_t now_ns = kd_clock_ns();
    if (p->trace)
        kd_trace_end(p->trace, 0, now_ns);
    add_sample(&p->frame_times, now_ns - p->frame_start_ns);
    for (uint32_t i = 0; i < p->zone_count; i++) {
        system_zone *zone = &p->zones[i];
        if (zone->ran)
            add_sample(&zone->cpu_times, zone->frame_ns);
        zone->ran = false;
        zone->frame_ns = 0;
    }
}

void kd_profile_begin(void *profile, uint32_t system, uint32_t worker)
{
    kd_profile *p = profile;
    assert(system < p->zone_count && worker < MAX_WORKERS);
    system_zone *zone = &p->zones[system];
    zone->outer = p->workers[worker].current;
    p->workers[worker].current = system;
    zone->inner_ns = 0;
    zone->start_ns = kd_clock_ns();
    if (p->trace)
        kd_trace_begin(p->trace, worker, zone->zone_name, zone->start_ns);
}

void kd_profile_end(void *profile, uint32_t system, uint32_t worker)
{
    kd_profile *p = profile;
    assert(system < p->zone_count && worker < MAX_WORKERS && p->workers[worker].current == system);
    system_zone *zone = &p->zones[system];
    uint64_t now_ns = kd_clock_ns(), ns = now_ns - zone->start_ns;
    if (p->trace)
        kd_trace_end(p->trace, worker, now_ns);
    zone->frame_ns += ns > zone->inner_ns ? ns - zone->inner_ns : 0;
    zone->ran = true;
    p->workers[worker].current = zone->outer;
    if (zone->outer != NO_ZONE)
        p->zones[zone->outer].inner_ns += ns;
}

/* ---- the timeline ---- */

kd_status kd_profile_trace(kd_profile *p, uint32_t workers)
{
    char text[128];
    assert(workers < KD_TRACE_MAX_TRACKS);
    kd_trace *trace = kd_trace_make(0, workers + 1);
    if (!trace)
        return kd_fail(KD_NO_MEMORY, "no memory for the timeline of the profile");
    for (uint32_t i = 0; i < workers; i++) {
        snprintf(text, sizeof text, i ? "worker %u" : "main", i);
        kd_trace_track(trace, i, KD_TRACE_THREAD, text);
    }
    kd_trace_track(trace, workers, KD_TRACE_GPU, "GPU");
    p->gpu_track = workers;
    p->frame_name = kd_trace_intern(trace, "frame", "frame");
    p->job_name = kd_trace_intern(trace, "job", "job");
    for (uint32_t i = 0; i < p->zone_count; i++) {
        p->zones[i].zone_name = kd_trace_intern(trace, p->zones[i].name, p->zones[i].phase);
        snprintf(text, sizeof text, "%s (part)", p->zones[i].name);
        p->zones[i].part_name = kd_trace_intern(trace, text, "job");
    }
    p->trace = trace;
    return KD_OK;
}

void kd_profile_job_begin(void *profile, uint32_t worker, uint32_t label)
{
    kd_profile *p = profile;
    bool known = label > 0 && label <= p->zone_count;
    kd_trace_begin(p->trace, worker, known ? p->zones[label - 1].part_name : p->job_name, kd_clock_ns());
}

void kd_profile_job_end(void *profile, uint32_t worker, uint32_t label)
{
    (void)label;
    kd_trace_end(((kd_profile *)profile)->trace, worker, kd_clock_ns());
}

void kd_profile_gpu_zone(kd_profile *p, uint32_t system, uint64_t start_ns, uint64_t end_ns)
{
    assert(system < p->zone_count);
    if (p->trace)
        kd_trace_zone(p->trace, p->gpu_track, p->zones[system].zone_name, start_ns, end_ns);
}

void kd_profile_gpu_pass(kd_profile *p, uint32_t name, uint64_t start_ns, uint64_t end_ns)
{
    if (p->trace)
        kd_trace_zone(p->trace, p->gpu_track, name, start_ns, end_ns);
}

uint32_t kd_profile_pass_name(kd_profile *p, const char *name)
{
    return p->trace ? kd_trace_intern(p->trace, name, "pass") : 0;
}

void kd_profile_allocated(kd_profile *p, uint64_t count, uint64_t bytes)
{
    kd_profile_allocations *a = &p->allocations;
    a->frames++;
    a->frames_without += count == 0;
    a->most = count > a->most ? count : a->most;
    a->most_bytes = bytes > a->most_bytes ? bytes : a->most_bytes;
    a->last = count;
    a->last_bytes = bytes;
}

kd_profile_allocations kd_profile_get_allocations(const kd_profile *p)
{
    return p->allocations;
}

uint32_t kd_profile_counter_name(kd_profile *p, const char *name)
{
    return p->trace ? kd_trace_intern(p->trace, name, PROFILE_COUNTERS) : 0;
}

void kd_profile_counter(kd_profile *p, uint32_t counter, double value)
{
    if (p->trace && counter)
        kd_trace_counter(p->trace, counter, value, kd_clock_ns());
}

kd_status kd_profile_write_trace(kd_profile *p, const char *path)
{
    assert(p->trace);
    kd_trace_sort(p->trace);
    if (kd_trace_dropped(p->trace))
        kd_log(KD_LOG_WARNING, "%s: the run was too long for one timeline; its last %llu events are missing",
               path, (unsigned long long)kd_trace_dropped(p->trace));
    return kd_path_has_extension(path, ".pftrace") ? profile_write_perfetto(p->trace, path)
                                                   : profile_write_chrome(p, p->trace, path);
}

void kd_profile_gpu(kd_profile *p, uint32_t system, uint64_t ns)
{
    assert(system < p->zone_count);
    add_sample(&p->zones[system].gpu_times, ns);
}

void kd_profile_bytes(kd_profile *p, uint32_t system, uint64_t bytes)
{
    assert(system < p->zone_count);
    p->zones[system].bytes = bytes;
}

void kd_profile_count(kd_profile *p, uint32_t system, const kd_profile_counts *counts)
{
    assert(system < p->zone_count);
    p->zones[system].counts = *counts;
}

/* ---- results ---- */

kd_profile_stats kd_profile_system_stats(const kd_profile *p, uint32_t system)
{
    assert(system < p->zone_count);
    const system_zone *zone = &p->zones[system];
    kd_profile_stats stats = summarize(zone->gpu_times.count ? &zone->gpu_times : &zone->cpu_times);
    stats.bytes = zone->bytes;
    stats.counts = zone->counts;
    return stats;
}

kd_profile_stats kd_profile_frame_stats(const kd_profile *p)
{
    kd_profile_stats stats = summarize(&p->frame_times);
    for (uint32_t i = 0; i < p->zone_count; i++)
        stats.bytes += p->zones[i].bytes;
    return stats;
}

/* What is reported of a system: GPU times where it has some. */
static const series *reported(const kd_profile *p, uint32_t system)
{
    if (system >= p->zone_count)
        return &p->frame_times;
    const system_zone *zone = &p->zones[system];
    return zone->gpu_times.count ? &zone->gpu_times : &zone->cpu_times;
}

profile_samples profile_system_samples(const kd_profile *p, uint32_t system)
{
    const series *s = reported(p, system);
    bool full = s->count > s->capacity;
    return (profile_samples){s->ns, full ? s->count % s->capacity : 0, full ? s->capacity : s->count};
}

uint32_t kd_profile_system_count(const kd_profile *p)
{
    return p->zone_count;
}

kd_profile_system kd_profile_system_at(const kd_profile *p, uint32_t index)
{
    const system_zone *zone = &p->zones[index];
    return (kd_profile_system){.name = zone->name, .phase = zone->phase, .gpu = zone->gpu};
}

const char *profile_clock(const kd_profile *p)
{
    return p->clock;
}

uint64_t kd_profile_newest(const kd_profile *p, uint32_t system, double *ms)
{
    const series *s = reported(p, system);
    *ms = s->count && s->capacity ? (double)s->ns[(s->count - 1) % s->capacity] * 1e-6 : 0;
    return s->count;
}
