#ifndef KD_PROFILE_PROFILE_H
#define KD_PROFILE_PROFILE_H

/* Statistics of a run, system by system.
 *
 * Every system is a zone on a CPU clock; one that records GPU work has GPU times besides, fed when they
 * arrive, and then reports those. CPU time is a system's own: what its worker did for others while it waited
 * is not counted. */

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "runtime/core/status.h"

struct kd_json;

typedef struct kd_profile kd_profile;

typedef struct kd_profile_system {
    const char *name;  /* copied */
    const char *phase; /* static text */
    bool gpu;          /* runs on the GPU lane */
} kd_profile_system;

/** Make a profile of these systems. Returns NULL when memory is out. */
kd_profile *kd_profile_make(const kd_profile_system *systems, uint32_t count);
void kd_profile_destroy(kd_profile *p);

/** Say how GPU times were taken ("timestamps", "finish after each pass"); the table repeats it. The text is
 * copied. */
void kd_profile_set_clock(kd_profile *p, const char *text);

/* ---- measuring ---- */

/** Begin and end a frame. Threading: the thread that makes frames, while no system runs. Cost: allocates
 * nothing unless the samples outgrow their buffers, which double. */
void kd_profile_frame_begin(kd_profile *p);
void kd_profile_frame_end(kd_profile *p);

/** Begin and end a system on a worker; zones of one worker nest. `profile` is a kd_profile: the type lets
 * both serve as hooks of a schedule. Threading: any worker, one at a time for each system. */
void kd_profile_begin(void *profile, uint32_t system, uint32_t worker);
void kd_profile_end(void *profile, uint32_t system, uint32_t worker);

/** Feed one GPU time of a system, of this frame or an earlier one. Threading: as frame_begin, or the GPU
 * lane. */
void kd_profile_gpu(kd_profile *p, uint32_t system, uint64_t ns);
/** Feed how much memory the last run of a system moved. */
void kd_profile_bytes(kd_profile *p, uint32_t system, uint64_t bytes);

/* What all of a run took from the heap, frame by frame. */
typedef struct kd_profile_allocations {
    uint64_t frames, frames_without; /* fed; without a single one */
    uint64_t most, most_bytes;       /* in one frame */
    uint64_t last, last_bytes;       /* in the newest */
} kd_profile_allocations;
/** Feed how often the frame that has just ended took memory, and how much of it. Threading: as frame_end. */
void kd_profile_allocated(kd_profile *p, uint64_t count, uint64_t bytes);
/** Get them. Zeros unless fed. */
kd_profile_allocations kd_profile_get_allocations(const kd_profile *p);

/* What a system did besides taking time: runs, the frames without one and why, rows its queries showed it. */
typedef struct kd_profile_counts {
    uint64_t runs, disabled, not_due, refused; /* switched off; not due by its rate; its condition said no */
    uint64_t rows;
} kd_profile_counts;
/** Feed the counts of a system so far. */
void kd_profile_count(kd_profile *p, uint32_t system, const kd_profile_counts *counts);

/* ---- the timeline: for --profile FILE; see trace.h ---- */

/** Keep every zone from now on, for this many workers. Errors NO_MEMORY */
kd_status kd_profile_trace(kd_profile *p, uint32_t workers);
/** Begin and end a job on a worker; `label` is the number of the system that it works for plus one, 0:
 * unknown. Both serve as hooks of a pool of jobs. */
void kd_profile_job_begin(void *profile, uint32_t worker, uint32_t label);
void kd_profile_job_end(void *profile, uint32_t worker, uint32_t label);
/** Record when the GPU ran a system, on the CPU's clock. Threading: the GPU lane. */
void kd_profile_gpu_zone(kd_profile *p, uint32_t system, uint64_t start_ns, uint64_t end_ns);
/** The same for a part of a system; the name is got once. */
uint32_t kd_profile_pass_name(kd_profile *p, const char *name);
void kd_profile_gpu_pass(kd_profile *p, uint32_t name, uint64_t start_ns, uint64_t end_ns);
/** Record a counter's value; the name is got once. Threading: the thread that makes frames. */
uint32_t kd_profile_counter_name(kd_profile *p, const char *name);
void kd_profile_counter(kd_profile *p, uint32_t counter, double value);
/** Write the timeline: Perfetto's format when the path ends in .pftrace, else Chrome's JSON. Nothing may be
 * recorded after. Errors as kd_file_write */
kd_status kd_profile_write_trace(kd_profile *p, const char *path);

/* ---- results ---- */

typedef struct kd_profile_stats {
    double median_ms; /* of an even number of samples: between the two in the middle */
    double p95_ms;    /* smallest sample that is not exceeded by 95 of 100 */
    double min_ms, max_ms, total_ms;
    uint64_t runs;
    uint64_t bytes;
    kd_profile_counts counts; /* zeros unless fed */
} kd_profile_stats;

/* Median, p95 and minimum are of the latest KD_PROFILE_SAMPLES runs, the others of all. */
#define KD_PROFILE_SAMPLES 65536u

kd_profile_stats kd_profile_system_stats(const kd_profile *p, uint32_t system);
kd_profile_stats kd_profile_frame_stats(const kd_profile *p);

uint32_t kd_profile_system_count(const kd_profile *p);
/** The text lives as long as the profile. */
kd_profile_system kd_profile_system_at(const kd_profile *p, uint32_t index);
/** Get the newest time of a system, by the clock that is reported; of the frame when `system` is the count of
 * systems. Returns how many there have been: unchanged when it did not run since. Cost: none */
uint64_t kd_profile_newest(const kd_profile *p, uint32_t system, double *ms);

/** Write the table: systems in order, a line for the whole frame, how it was measured. */
void kd_profile_write_table(const kd_profile *p, FILE *out);
/** Write which systems became slower or faster since the run that wrote the timeline `old_path` (JSON), by a
 * test that heeds noise: see compare.c. Errors as kd_file_read, BAD_FORMAT */
kd_status kd_profile_compare(const kd_profile *p, const char *old_path, FILE *out);
/** Tell before a run whether that file can be read. Errors as kd_profile_compare */
kd_status kd_profile_check_old(const char *old_path);
/** Write the members "frame_ms" and "systems" into the object that is open in `json`. */
void kd_profile_write_json(const kd_profile *p, struct kd_json *json);

#endif
