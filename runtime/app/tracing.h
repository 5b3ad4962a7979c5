#ifndef KD_APP_TRACING_H
#define KD_APP_TRACING_H

#include "runtime/app/options.h"
#include "runtime/app/scene.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"
#include "runtime/reference/reference.h"

/** `kandil reference`: bring the world to a frame, path trace it, write the terms asked for. Errors with one
 * message */
kd_status app_reference_run(const app_options *options);

/** Number of the frame that the options ask for. */
uint64_t app_tracing_frame(const app_scene *scene, const app_options *options);

/* A world brought to a frame by its CPU systems alone, and its path traced picture. */
typedef struct app_traced {
    const app_options *options;
    app_tracing asked; /* as the options say, defaults filled in */
    kd_jobs *jobs;
    kd_world *world;
    kd_schedule *schedule;
    app_scene scene;
    kd_reference *reference; /* NULL after a failure that left no picture */
} app_traced;

/** Load, step and trace what the options say, with a progress bar.
 *  Errors  INTERRUPTED, of which the picture is kept; any other with one message. Close in all cases
 */
kd_status app_traced_open(app_traced *traced, const app_options *options);
void app_traced_close(app_traced *traced);

#endif
