#ifndef KD_APP_WINDOW_WINDOW_H
#define KD_APP_WINDOW_WINDOW_H

/* `kandil run SCENE --window`: the picture in a window, panels over it, a camera that can be moved. */

#include "runtime/app/stage.h"

typedef struct app_window_desc {
    const app_options *options;
    kd_jobs *jobs;
    kd_gpu *gpu;           /* with a visible window */
    app_stage **stage;     /* opened; another takes its place when a scene is changed */
    app_stage_desc reopen; /* how another is opened */
    uint64_t frame_count;  /* UINT64_MAX: until the window is closed */
} app_window_desc;

/** Show the scene until the window is closed or the frames are done.
 *
 *  Returns  *done: frames of the scene that is on at the end
 *  Errors   what a frame gave that cannot be mended while the window is open; INTERRUPTED
 */
kd_status app_window_run(const app_window_desc *desc, uint64_t *done);

#endif
