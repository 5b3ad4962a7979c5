#ifndef KD_APP_TIMING_H
#define KD_APP_TIMING_H

/* Feeds the profile with the time of every system and of the whole frame, by the hooks of the schedule. GPU
 * systems are timed by pairs of timestamps read some frames later, or, in sync mode, by finishing before and
 * after and reading the CPU's clock: the only figure that software drivers can be trusted with. */

#include "runtime/ecs/system.h"
#include "runtime/gpu/gpu.h"
#include "runtime/profile/profile.h"

typedef enum app_timing_mode {
    APP_TIMING_OFF,    /* frames only */
    APP_TIMING_STAMPS, /* GPU timestamps */
    APP_TIMING_SYNC,   /* finish each GPU system */
} app_timing_mode;

typedef struct app_timing {
    kd_schedule *schedule;
    kd_gpu *gpu;
    kd_profile *profile;
    app_timing_mode mode;
    uint64_t newest_stamps; /* frame whose timestamps were taken last */
} app_timing;

/** Hook into a schedule whose systems are all registered. Errors NO_MEMORY */
kd_status app_timing_open(app_timing *timing, kd_schedule *s, kd_gpu *gpu, app_timing_mode mode);
void app_timing_frame_begin(app_timing *timing);
void app_timing_frame_end(app_timing *timing); /* after kd_gpu_end_frame */
/** Take over what the schedule counted, before a report. */
void app_timing_finish(app_timing *t);
void app_timing_close(app_timing *timing);

#endif
