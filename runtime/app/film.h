#ifndef KD_APP_FILM_H
#define KD_APP_FILM_H

/* An .mp4 (H.264) or .webm (VP9) written by an ffmpeg child: 4:2:0, BT.709, odd sides padded to even, a
 * constant rate. The film stands under its name only when it is whole. */

#include <stdint.h>

#include "runtime/core/file.h"
#include "runtime/core/status.h"

#include "runtime/app/child.h"

typedef struct app_film {
    app_child child;
    char path[KD_PATH_MAX];
    char temp[KD_PATH_MAX];
    size_t frame_bytes;
    uint64_t frames;
} app_film;

/** Start the film. Errors IO with a message */
kd_status app_film_open(app_film *film, const char *path, uint32_t width, uint32_t height, double fps);
/** Add a frame of RGBA texels, row 0 on top. Errors IO with a message, after which the film is gone */
kd_status app_film_write(app_film *film, const void *rgba);
/** Finish; a film without frames leaves no file. Errors IO with a message. Does nothing after a failed write.
 */
kd_status app_film_close(app_film *film);

#endif
