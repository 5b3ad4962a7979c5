#include "runtime/profile/trace.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"

enum { FIRST_NAMES = 256 };

typedef struct open_zone {
    kd_trace_name name;
    uint64_t start_ns;
} open_zone;

typedef struct trace_track {
    char *name;
    kd_trace_kind kind;
    kd_trace_event *events;
    uint64_t count, capacity, dropped;
    uint32_t depth;
    open_zone open[KD_TRACE_MAX_DEPTH];
} trace_track;

typedef struct trace_text {
    char *text;
    const char *category;
} trace_text;

struct kd_trace {
    uint64_t start_ns;
    uint32_t track_count;
    trace_track *tracks;
    trace_text *names;
    uint32_t name_count, name_capacity;
    kd_trace_value *values;
    uint64_t value_count, value_capacity, values_dropped;
};

/* ---- making ---- */

kd_trace *kd_trace_make(size_t limit_bytes, uint32_t track_count)
{
    kd_trace *t = calloc(1, sizeof *t);
    assert(track_count <= KD_TRACE_MAX_TRACKS);
    if (!t)
        return NULL;
    size_t share = (limit_bytes ? limit_bytes : (size_t)512 << 20) / (track_count + 1);
    t->start_ns = kd_clock_ns();
    t->tracks = calloc(track_count + 1, sizeof *t->tracks);
    t->values = malloc(share + sizeof *t->values);
    t->value_capacity = t->values ? share / sizeof *t->values : 0;
    bool ok = t->tracks && t->values && kd_trace_intern(t, "", "") == 0 && t->name_count == 1;
    for (uint32_t i = 0; i < track_count && ok; i++) {
        t->tracks[i].events = malloc(share + sizeof *t->tracks[i].events);
        t->tracks[i].capacity = share / sizeof *t->tracks[i].events;
        t->track_count = i + 1;
        ok = t->tracks[i].events != NULL;
    }
    if (ok)
        return t;
    kd_trace_destroy(t);
    return NULL;
}

void kd_trace_destroy(kd_trace *t)
{
    if (!t)
        return;
    for (uint32_t i = 0; i < t->track_count; i++) {
        free(t->tracks[i].name);
        free(t->tracks[i].events);
    }
    for (uint32_t i = 0; i < t->name_count; i++)
        free(t->names[i].text);
    free(t->tracks);
    free(t->names);
    free(t->values);
    free(t);
}

void kd_trace_track(kd_trace *t, uint32_t track, kd_trace_kind kind, const char *name)
{
    assert(track < t->track_count);
    free(t->tracks[track].name);
    t->tracks[track].name = strdup(name);
    t->tracks[track].kind = kind;
}

kd_trace_name kd_trace_intern(kd_trace *t, const char *name, const char *category)
{
    for (uint32_t i = 0; i < t->name_count; i++)
        if (strcmp(t->names[i].text, name) == 0 && strcmp(t->names[i].category, category) == 0)
            return i;
    if (t->name_count == t->name_capacity) {
        uint32_t capacity = t->name_capacity ? t->name_capacity * 2 : FIRST_NAMES;
        trace_text *grown = realloc(t->names, capacity * sizeof *grown);
        if (!grown)
            return 0;
        t->names = grown;
        t->name_capacity = capacity;
    }
    char *copy = strdup(name);
    if (!copy)
        return 0;
    t->names[t->name_count] = (trace_text){copy, category};
    return t->name_count++;
}

/* ---- recording ---- */

void kd_trace_zone(kd_trace *t, uint32_t track, kd_trace_name name, uint64_t start_ns, uint64_t end_ns)
{
    assert(track < t->track_count);
    trace_track *to = &t->tracks[track];
    if (to->count == to->capacity) {
        to->dropped++;
        return;
    }
    to->events[to->count++] = (kd_trace_event){start_ns, end_ns < start_ns ? start_ns : end_ns, name, 0};
}

void kd_trace_begin(kd_trace *t, uint32_t track, kd_trace_name name, uint64_t ns)
{
    assert(track < t->track_count);
    trace_track *to = &t->tracks[track];
    if (to->depth < KD_TRACE_MAX_DEPTH)
        to->open[to->depth] = (open_zone){name, ns};
    to->depth++;
}

void kd_trace_end(kd_trace *t, uint32_t track, uint64_t ns)
{
    assert(track < t->track_count && t->tracks[track].depth > 0);
    trace_track *to = &t->tracks[track];
    if (--to->depth < KD_TRACE_MAX_DEPTH)
        kd_trace_zone(t, track, to->open[to->depth].name, to->open[to->depth].start_ns, ns);
    else
        to->dropped++;
}

void kd_trace_counter(kd_trace *t, kd_trace_name name, double value, uint64_t ns)
{
    if (t->value_count == t->value_capacity)
        t->values_dropped++;
    else
        t->values[t->value_count++] = (kd_trace_value){ns, value, name};
}

/* ---- order ---- */

/* Zones that begin together: the longer one is round the other; of equal ones the one recorded later is, as
 * zones are recorded when they end. Its place is kept in .depth meanwhile. */
static int compare_events(const void *left, const void *right)
{
    const kd_trace_event *a = left, *b = right;
    if (a->start_ns != b->start_ns)
        return a->start_ns < b->start_ns ? -1 : 1;
    if (a->end_ns != b->end_ns)
        return a->end_ns > b->end_ns ? -1 : 1;
    return (a->depth < b->depth) - (a->depth > b->depth);
}

static void nest(trace_track *track)
{
    uint64_t ends[KD_TRACE_MAX_DEPTH];
    uint32_t depth = 0;
    for (uint64_t i = 0; i < track->count; i++) {
        kd_trace_event *e = &track->events[i];
        while (depth > 0 && ends[depth - 1] <= e->start_ns)
            depth--;
        if (depth > 0 && e->end_ns > ends[depth - 1])
            e->end_ns = ends[depth - 1];
        e->depth = depth;
        if (depth < KD_TRACE_MAX_DEPTH)
            ends[depth++] = e->end_ns;
    }
}

void kd_trace_sort(kd_trace *t)
{
    for (uint32_t i = 0; i < t->track_count; i++) {
        trace_track *track = &t->tracks[i];
        for (uint64_t k = 0; k < track->count; k++)
            track->events[k].depth = (uint32_t)k;
        if (track->count)
            qsort(track->events, track->count, sizeof *track->events, compare_events);
        nest(track);
    }
}

/* ---- reading ---- */

uint32_t kd_trace_track_count(const kd_trace *t)
{
    return t->track_count;
}

const char *kd_trace_track_name(const kd_trace *t, uint32_t track, kd_trace_kind *kind)
{
    *kind = t->tracks[track].kind;
    return t->tracks[track].name;
}

const kd_trace_event *kd_trace_events(const kd_trace *t, uint32_t track, uint64_t *count)
{
    *count = t->tracks[track].count;
    return t->tracks[track].events;
}

const kd_trace_value *kd_trace_values(const kd_trace *t, uint64_t *count)
{
    *count = t->value_count;
    return t->values;
}

uint32_t kd_trace_name_count(const kd_trace *t)
{
    return t->name_count;
}

const char *kd_trace_name_text(const kd_trace *t, kd_trace_name name, const char **category)
{
    *category = t->names[name].category;
    return t->names[name].text;
}

uint64_t kd_trace_dropped(const kd_trace *t)
{
    uint64_t dropped = t->values_dropped;
    for (uint32_t i = 0; i < t->track_count; i++)
        dropped += t->tracks[i].dropped;
    return dropped;
}

uint64_t kd_trace_start_ns(const kd_trace *t)
{
    return t->start_ns;
}
