#ifndef KD_APP_STAGE_H
#define KD_APP_STAGE_H

/* A scene that is on: its world, its systems on the GPU, its clock and what is written of it. A window puts
 * one in the place of another; jobs and GPU outlive them. */

#include "runtime/app/capture.h"
#include "runtime/app/exposure.h"
#include "runtime/app/scene.h"
#include "runtime/app/timing.h"
#include "runtime/asset/voxel_file.h"

typedef struct app_stage {
    app_options options; /* a copy; what they point to is the caller's */
    kd_jobs *jobs;       /* of the caller, as is the GPU */
    kd_gpu *gpu;         /* NULL until it is opened */
    kd_world *world;
    kd_schedule *schedule;
    app_scene scene;
    app_capture *capture;   /* NULL: nothing is written */
    app_exposure *exposure; /* NULL: a frame is one moment */
    bool without_gpu;       /* systems of the GPU lane are off */
    app_timing timing;
    kd_voxel_file voxels; /* of --voxels */
} app_stage;

typedef struct app_stage_desc {
    kd_gpu *gpu;
    app_timing_mode timing;
    bool trace;    /* keep a timeline */
    bool captures; /* write what the options ask for */
} app_stage_desc;

/** Make the world and fill it; nothing touches the GPU. Jobs, and what the options point to, are borrowed
 * while it is on. beside  a stage from the same files, whose models are shared; or NULL. Errors  with one
 * message, *out is NULL then */
kd_status app_stage_load(const app_options *options, kd_jobs *jobs, const app_stage *beside, app_stage **out);
/** Register and open its systems. Errors with one message; it can only be closed then */
kd_status app_stage_open(app_stage *stage, const app_stage_desc *desc);
/** Fill the world anew from its files, with the same systems: what the GPU has of it stays and is used again.
 * Errors as app_scene_renew */
kd_status app_stage_renew(app_stage *stage);
/** Bring the world to simulation step `index` and run every system. */
kd_status app_stage_frame(app_stage *stage, uint64_t index);
/** Run every system once more on the world as it is: no time passes. */
kd_status app_stage_again(app_stage *stage, uint64_t index);
/** Switch the systems of the GPU lane on or off. */
void app_stage_enable_gpu(app_stage *stage, bool enabled);
void app_stage_close(app_stage *stage); /* NULL does nothing */

#endif
