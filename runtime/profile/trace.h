#ifndef KD_PROFILE_TRACE_H
#define KD_PROFILE_TRACE_H

/* A timeline of zones and counters, kept while the program runs and written at its end.
 *
 * Every track is written by one thread at a time and has its own array, which is reserved at the start and
 * touched only as far as it is filled: recording takes no lock and allocates nothing. A track that is full
 * drops what comes later, and counts it. */

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "runtime/core/status.h"

#define KD_TRACE_MAX_TRACKS 66
#define KD_TRACE_MAX_DEPTH  64 /* of open zones on a track */

typedef struct kd_trace kd_trace;
typedef uint32_t kd_trace_name; /* of a zone or counter; 0 is "" */

typedef enum kd_trace_kind { KD_TRACE_THREAD, KD_TRACE_GPU } kd_trace_kind;

/** Make a trace of at most `limit_bytes` (0: 512 MiB, of which a page counts when it is used).
 *  Returns NULL when memory is out */
kd_trace *kd_trace_make(size_t limit_bytes, uint32_t track_count);
void kd_trace_destroy(kd_trace *t);
/** Name a track; the name is copied. A track that has no name is not written. */
void kd_trace_track(kd_trace *t, uint32_t track, kd_trace_kind kind, const char *name);

/** Find the number of a name, which is copied, and of the category under which viewers file it (static text).
 *  Returns 0 when memory is out. Threading: one thread. */
kd_trace_name kd_trace_intern(kd_trace *t, const char *name, const char *category);

/* ---- recording: ns on the CPU's monotonic clock ---- */
/** Open and close zones of a track, which nest. Threading: the track's own thread. */
void kd_trace_begin(kd_trace *t, uint32_t track, kd_trace_name name, uint64_t ns);
void kd_trace_end(kd_trace *t, uint32_t track, uint64_t ns);
/** Record a zone that is over. Zones of a track may come in any order, but lie beside or inside each other.
 */
void kd_trace_zone(kd_trace *t, uint32_t track, kd_trace_name name, uint64_t start_ns, uint64_t end_ns);
/** Record a counter's value from now on. Threading: one thread for all counters. */
void kd_trace_counter(kd_trace *t, kd_trace_name name, double value, uint64_t ns);

/* ---- writing: nothing records any more ---- */
typedef struct kd_trace_event {
    uint64_t start_ns, end_ns;
    kd_trace_name name;
    uint32_t depth; /* zones round it; set by kd_trace_sort */
} kd_trace_event;

typedef struct kd_trace_value {
    uint64_t ns;
    double value;
    kd_trace_name name;
} kd_trace_value;

/** Bring every track into order of time, outer zones before inner ones, and cut what the clocks let stick out
 * of its outer zone. */
void kd_trace_sort(kd_trace *t);
uint32_t kd_trace_track_count(const kd_trace *t);
const char *kd_trace_track_name(const kd_trace *t, uint32_t track, kd_trace_kind *kind); /* NULL: not used */
const kd_trace_event *kd_trace_events(const kd_trace *t, uint32_t track, uint64_t *count);
const kd_trace_value *kd_trace_values(const kd_trace *t, uint64_t *count);
uint32_t kd_trace_name_count(const kd_trace *t);
const char *kd_trace_name_text(const kd_trace *t, kd_trace_name name, const char **category);
uint64_t kd_trace_dropped(const kd_trace *t);
uint64_t kd_trace_start_ns(const kd_trace *t); /* when it was made; nothing is earlier */

#endif
