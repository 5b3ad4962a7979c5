#ifndef KD_TESTS_PFTRACE_H
#define KD_TESTS_PFTRACE_H

/* A decoder of Perfetto traces for tests, written from the format alone: fields by number and wire type.
 * Included once, by the test's only source. */

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct pf_field {
    uint32_t number, wire;
    uint64_t value; /* of a varint, or the bits of a fixed one */
    const uint8_t *data;
    size_t size;
} pf_field;

typedef struct pf_span {
    const uint8_t *at, *end;
    bool broken;
} pf_span;

static inline uint64_t pf_varint(pf_span *s)
{
    uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
        if (s->at == s->end)
            break;
        uint8_t byte = *s->at++;
        value |= (uint64_t)(byte & 0x7F) << shift;
        if (!(byte & 0x80))
            return value;
    }
    s->broken = true;
    return 0;
}

/* Take the next field; false at the end or when the bytes are no message. */
static inline bool pf_next(pf_span *s, pf_field *f)
{
    if (s->at == s->end || s->broken)
        return false;
    uint64_t tag = pf_varint(s);
    *f = (pf_field){.number = (uint32_t)(tag >> 3), .wire = (uint32_t)(tag & 7)};
    size_t left = (size_t)(s->end - s->at), fixed = f->wire == 1 ? 8 : f->wire == 5 ? 4 : 0;
    if (f->wire == 0) {
        f->value = pf_varint(s);
    } else if (fixed && left >= fixed) {
        for (size_t i = 0; i < fixed; i++)
            f->value |= (uint64_t)s->at[i] << 8 * i;
        s->at += fixed;
    } else if (f->wire == 2) {
        f->size = (size_t)pf_varint(s);
        f->data = s->at;
        s->broken = s->broken || f->size > (size_t)(s->end - s->at);
        s->at += s->broken ? 0 : f->size;
    } else {
        s->broken = true;
    }
    s->broken = s->broken || f->number == 0;
    return !s->broken;
}

/* ---- what a trace says ---- */

#define PF_MAX_TRACKS 64
#define PF_MAX_NAMES  512
#define PF_MAX_DEPTH  64

typedef struct pf_zone {
    uint64_t track, start_ns, end_ns;
    char name[64];
    uint32_t depth;
} pf_zone;

typedef struct pf_track {
    uint64_t uuid, parent;
    char name[64];
    bool thread, counter;
    uint64_t last_ns;
    uint32_t depth;
    size_t open[PF_MAX_DEPTH]; /* zones */
} pf_track;

typedef struct pf_trace {
    pf_track tracks[PF_MAX_TRACKS];
    uint32_t track_count;
    char names[PF_MAX_NAMES][64];
    pf_zone *zones; /* in order of their beginning, track by track */
    size_t zone_count, value_count;
    const char *mistake; /* NULL: none */
} pf_trace;

static inline void pf_copy(char out[64], const pf_field *f)
{
    size_t size = f->size < 63 ? f->size : 63;
    memcpy(out, f->data, size);
    out[size] = '\0';
}

static inline pf_span pf_inside(const pf_field *f)
{
    return (pf_span){f->data, f->data + f->size, false};
}

static inline pf_track *pf_find(pf_trace *t, uint64_t uuid)
{
    for (uint32_t i = 0; i < t->track_count; i++)
        if (t->tracks[i].uuid == uuid)
            return &t->tracks[i];
    return NULL;
}

static inline void pf_read_track(pf_trace *t, const pf_field *message)
{
    pf_span s = pf_inside(message);
    pf_track track = {0};
    for (pf_field f; pf_next(&s, &f);) {
        if (f.number == 1)
            track.uuid = f.value;
        if (f.number == 2)
            pf_copy(track.name, &f);
        if (f.number == 5)
            track.parent = f.value;
        track.counter = track.counter || f.number == 8;
        if (f.number != 4)
            continue;
        track.thread = true;
        pf_span inner = pf_inside(&f);
        for (pf_field g; pf_next(&inner, &g);)
            if (g.number == 5)
                pf_copy(track.name, &g);
    }
    if (s.broken || !track.uuid || pf_find(t, track.uuid) || t->track_count == PF_MAX_TRACKS)
        t->mistake = "a track descriptor is broken, or its uuid is not its own";
    else
        t->tracks[t->track_count++] = track;
}

/* Names alone; categories have the same shape. */
static inline void pf_read_interned(pf_trace *t, const pf_field *message)
{
    pf_span s = pf_inside(message);
    for (pf_field f; pf_next(&s, &f);) {
        uint64_t id = 0;
        pf_span inner = pf_inside(&f);
        for (pf_field g; f.number == 2 && pf_next(&inner, &g);) {
            if (g.number == 1)
                id = g.value;
            if (g.number == 2 && id && id < PF_MAX_NAMES)
                pf_copy(t->names[id], &g);
        }
    }
}

static inline void pf_begin(pf_trace *t, pf_track *track, uint64_t ns, uint64_t name)
{
    if (name >= PF_MAX_NAMES || track->depth == PF_MAX_DEPTH || track->counter) {
        t->mistake = "a zone has no name, lies too deep, or on a counter";
        return;
    }
    pf_zone *grown = realloc(t->zones, (t->zone_count + 1) * sizeof *grown);
    if (!grown)
        abort();
    t->zones = grown;
    pf_zone *zone = &grown[t->zone_count];
    *zone = (pf_zone){.track = track->uuid, .start_ns = ns, .depth = track->depth};
    memcpy(zone->name, t->names[name], sizeof zone->name);
    track->open[track->depth++] = t->zone_count++;
}

static inline void pf_event(pf_trace *t, const pf_field *message, uint64_t ns)
{
    uint64_t type = 0, name = 0, uuid = 0;
    bool value = false;
    pf_span s = pf_inside(message);
    for (pf_field f; pf_next(&s, &f);) {
        type = f.number == 9 ? f.value : type;
        name = f.number == 10 ? f.value : name;
        uuid = f.number == 11 ? f.value : uuid;
        value = value || (f.number == 44 && f.wire == 1);
    }
    pf_track *track = pf_find(t, uuid);
    if (s.broken || !track || (type == 4) != track->counter || (type == 4) != value) {
        t->mistake = "an event is broken, or of no track";
        return;
    }
    if (ns < track->last_ns)
        t->mistake = "a track's events are out of order";
    track->last_ns = ns;
    if (type == 1)
        pf_begin(t, track, ns, name);
    else if (type == 2 && track->depth == 0)
        t->mistake = "a zone ends that never began";
    else if (type == 2)
        t->zones[track->open[--track->depth]].end_ns = ns;
    else
        t->value_count++;
}

static inline void pf_packet(pf_trace *t, const pf_field *message)
{
    uint64_t ns = 0, sequence = 0;
    pf_span s = pf_inside(message);
    for (pf_field f; pf_next(&s, &f);) {
        ns = f.number == 8 ? f.value : ns;
        sequence = f.number == 10 ? f.value : sequence;
        if (f.number == 60)
            pf_read_track(t, &f);
        if (f.number == 12)
            pf_read_interned(t, &f);
        if (f.number == 11)
            pf_event(t, &f, ns);
    }
    if (s.broken || !sequence)
        t->mistake = "a packet is broken, or has no sequence";
}

/* Decode a file. .mistake says what is wrong with it. Free .zones. */
static inline pf_trace pf_decode(const char *path)
{
    pf_trace t = {.mistake = NULL};
    static uint8_t bytes[1 << 24];
    FILE *file = fopen(path, "rb");
    size_t size = file ? fread(bytes, 1, sizeof bytes, file) : 0;
    if (file)
        fclose(file);
    pf_span s = {bytes, bytes + size, false};
    for (pf_field f; pf_next(&s, &f);) {
        if (f.number == 1 && f.wire == 2)
            pf_packet(&t, &f);
        else
            t.mistake = "the file holds something else than packets";
    }
    if (s.broken || !size)
        t.mistake = "the file is broken or empty";
    for (uint32_t i = 0; i < t.track_count; i++)
        if (t.tracks[i].depth)
            t.mistake = "a zone never ends";
    return t;
}

#endif
