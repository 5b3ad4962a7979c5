#ifndef KD_APP_TIMING_H
#define KD_APP_TIMING_H

/* Feeds the profile with the time of every system and of the whole frame, by the hooks of the schedule. GPU
 * systems are timed by pairs of timestamps read some frames later, or, in sync mode, by finishing before and
 * after and reading the CPU's clock: the only figure that software drivers can be trusted with. */

#include "runtime/core/allocations.h"
#include "runtime/app/gpu_timing.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

typedef enum app_timing_mode {
    APP_TIMING_OFF,    /* frames only */
    APP_TIMING_STAMPS, /* GPU timestamps */
    APP_TIMING_SYNC,   /* finish each GPU system */
} app_timing_mode;

/* Rows of the profile beside the systems: with them all of a frame is accounted for. */
typedef enum app_timing_row {
    APP_ROW_SCENARIO,
    APP_ROW_MERGE, /* commands */
    APP_ROW_WAIT,  /* the GPU lane waits for systems on other workers */
    APP_ROW_END,   /* of the frame: what the driver does then */
    APP_ROW_GPU_FRAME,
    APP_ROW_GPU_IDLE, /* of the GPU's frame: between systems */
    APP_ROW_COUNT
} app_timing_row;

enum {
    APP_COUNTER_VOXELS,
    APP_COUNTER_NODES,
    APP_COUNTER_ENTITIES,
    APP_COUNTER_GPU_BYTES,
    APP_COUNTER_HEAP_BYTES,
    APP_COUNTER_WORLD_BYTES,
    APP_COUNTER_ALLOCATIONS,
    APP_COUNTER_ALLOCATED_BYTES,
    APP_COUNTER_COUNT
};

typedef struct app_timing {
    kd_schedule *schedule;
    kd_gpu *gpu;
    kd_world *world;
    kd_profile *profile;
    app_gpu_timing *gpu_timing;
    app_timing_mode mode;
    bool trace;
    uint32_t first_row; /* of those above */
    uint32_t counters[APP_COUNTER_COUNT];
    kd_allocations before; /* the frame that runs */
} app_timing;

typedef struct app_timing_desc {
    kd_schedule *schedule; /* all systems are registered */
    kd_gpu *gpu;
    kd_world *world;
    kd_jobs *jobs;
    app_timing_mode mode;
    bool trace; /* keep everything for kd_profile_write_trace */
} app_timing_desc;

/** Hook into the schedule and, with `trace`, into the jobs, of which none may run. Errors NO_MEMORY */
kd_status app_timing_open(app_timing *timing, const app_timing_desc *desc);
/** Begin and end a row. APP_ROW_END is ended by app_timing_frame_end. Threading: the GPU lane */
void app_timing_section(app_timing *timing, app_timing_row row, bool begins);
void app_timing_frame_begin(app_timing *timing);
void app_timing_frame_end(app_timing *timing); /* after kd_gpu_end_frame */
/** Take over what the schedule counted, before a report. */
void app_timing_finish(app_timing *t);
void app_timing_close(app_timing *timing);

#endif
