#ifndef KD_APP_CAPTURE_H
#define KD_APP_CAPTURE_H

/* From the picture to files. System `capture` queues copies of the frames that a film or a numbered sequence
 * wants; they come back a few frames later through a fenced ring and are encoded by workers. Single pictures
 * show the last frame and are read at the end. Frames that were finished stay, whatever happens later. */

#include "runtime/app/options.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

typedef struct app_capture app_capture;

/** Tell, before any work is done, whether the outputs can be written at all. Errors with a message */
kd_status app_capture_check(const app_options *options);

/** Open films and rings for pictures of this size. Errors with a message. The options are kept. */
kd_status app_capture_open(const app_options *options, kd_world *w, kd_gpu *gpu, kd_jobs *jobs,
                           uint32_t width, uint32_t height, double fps, app_capture **out);

/** Register system capture. */
kd_status app_capture_import(app_capture *capture, kd_schedule *s);

/** Tell whether some output still lacks the frame: a film needs every one, single pictures the last. */
bool app_capture_wants(const app_capture *capture, uint64_t frame, bool last);
/** Let frames pass by unwritten, or go on writing them. */
void app_capture_rest(app_capture *capture, bool rests);

/** How the files written so far fared. Threading: the GPU lane. Cost: none. */
kd_status app_capture_status(const app_capture *capture);

/** Write everything that is still under way; with `last` also the single pictures, which show the frame
 * rendered last. capture  NULL: nothing is written */
kd_status app_capture_finish(app_capture *capture, bool last);

void app_capture_close(app_capture *capture); /* NULL does nothing; unfinished films leave no file */

#endif
