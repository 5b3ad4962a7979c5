#ifndef KD_APP_TRACING_H
#define KD_APP_TRACING_H

#include "runtime/app/options.h"
#include "runtime/app/scene.h"
#include "runtime/jobs/jobs.h"
#include "runtime/reference/reference.h"

/** `kandil reference`: bring the world to a frame, path trace it, write the terms asked for. Errors with one
 * message */
kd_status app_reference_run(const app_options *options);

/** Number of the frame that the options ask for. */
uint64_t app_tracing_frame(const app_scene *scene, const app_options *options);

/** Path trace the world as it is now, with a progress bar. `extra`: terms beside those of the options.
 *  Errors  as kd_reference_open and kd_reference_render; *out is NULL unless it is to be closed
 */
kd_status app_trace_world(kd_world *w, kd_jobs *jobs, const app_options *options, kd_reference **out);

#endif
