#ifndef KD_APP_TIMING_H
#define KD_APP_TIMING_H

/* Time of every system and of the whole frame, by the hooks of the schedule. GPU systems are timed by pairs
 * of timestamps read some frames later, or, in sync mode, by finishing before and after and reading the CPU's
 * clock: the only figure that software drivers can be trusted with. */

#include "runtime/ecs/system.h"
#include "runtime/gpu/gpu.h"
#include "runtime/jobs/jobs.h"

typedef enum app_timing_mode {
    APP_TIMING_OFF,    /* frames only */
    APP_TIMING_STAMPS, /* GPU timestamps */
    APP_TIMING_SYNC,   /* finish each GPU system */
} app_timing_mode;

typedef struct app_samples {
    float *ms;
    uint32_t count, capacity;
} app_samples;

typedef struct app_summary {
    uint32_t count;
    double median, p95, max; /* ms; 0 without samples */
} app_summary;

typedef struct app_timing {
    kd_schedule *schedule;
    kd_gpu *gpu;
    app_timing_mode mode;
    uint32_t system_count;
    uint64_t *began_ns;      /* [system] */
    app_samples *systems;    /* [system] */
    uint64_t *bytes;         /* [system] moved in the last run */
    kd_system_context moved; /* what bytes_moved is asked with */
    app_samples frames;
    uint64_t frame_began_ns, newest_stamps;
} app_timing;

/** Hook into a schedule whose systems are all registered. Errors NO_MEMORY */
kd_status app_timing_open(app_timing *timing, kd_schedule *s, kd_world *w, kd_gpu *gpu, kd_jobs *jobs,
                          app_timing_mode mode);
void app_timing_frame_begin(app_timing *timing);
void app_timing_frame_end(app_timing *timing); /* after kd_gpu_end_frame */
void app_timing_close(app_timing *timing);

/** Summarise; p95 by nearest rank. */
app_summary app_summarise(const app_samples *samples);

/** Print the table that `--profile table` asks for. */
void app_timing_print(const app_timing *timing);

#endif
