/* A series of samples for the frame and two for each system (CPU and GPU clock). Within a frame a system adds
 * to its own sum only; the frame's end, when nothing runs, turns sums into samples, so that no lock is needed
 * and buffers grow only there. */
#include "runtime/profile/profile.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
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
    uint64_t start_ns, inner_ns; /* inner: spent in zones that began inside this one */
    uint32_t outer;              /* the zone round it on the same worker */
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
    worker_state workers[MAX_WORKERS];
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
}

void kd_profile_frame_end(kd_profile *p)
{
    add_sample(&p->frame_times, kd_clock_ns() - p->frame_start_ns);
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
}

void kd_profile_end(void *profile, uint32_t system, uint32_t worker)
{
    kd_profile *p = profile;
    assert(system < p->zone_count && worker < MAX_WORKERS && p->workers[worker].current == system);
    system_zone *zone = &p->zones[system];
    uint64_t ns = kd_clock_ns() - zone->start_ns;
    zone->frame_ns += ns > zone->inner_ns ? ns - zone->inner_ns : 0;
    zone->ran = true;
    p->workers[worker].current = zone->outer;
    if (zone->outer != NO_ZONE)
        p->zones[zone->outer].inner_ns += ns;
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

uint32_t profile_system_count(const kd_profile *p)
{
    return p->zone_count;
}

kd_profile_system profile_system(const kd_profile *p, uint32_t index)
{
    const system_zone *zone = &p->zones[index];
    return (kd_profile_system){.name = zone->name, .phase = zone->phase, .gpu = zone->gpu};
}

const char *profile_clock(const kd_profile *p)
{
    return p->clock;
}
