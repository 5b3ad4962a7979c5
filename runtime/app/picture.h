#ifndef KD_APP_PICTURE_H
#define KD_APP_PICTURE_H

/* Pictures in floats, from and to files. */

#include <stdbool.h>
#include <stdint.h>

#include "runtime/core/settings.h"
#include "runtime/core/status.h"

typedef struct app_picture {
    uint32_t width, height;
    bool encoded; /* sRGB codes 0 … 1 rather than linear radiance */
    float *rgb;   /* height rows of width texels, row 0 on top */
} app_picture;

/** Make a black picture. Errors NO_MEMORY with a message */
kd_status app_picture_make(app_picture *out, uint32_t width, uint32_t height);
void app_picture_fini(app_picture *picture);

/** Read a .png (encoded) or .exr (linear) file. Errors as kd_file_read; BAD_FORMAT, also for pixels that are
 * no finite number; one message */
kd_status app_picture_read(const char *path, app_picture *out);

/** Tell whether a .png or .exr file was written to its end: a .png ends in its last chunk, an .exr (of one part,
 * as they are written here) where its last block of lines does. Writes no message. Threading: one at a time */
bool app_picture_is_whole(const char *path);

/** Encode to sRGB bytes, four a texel, which the caller frees; linear ones by exposure and curve. NULL
 * without memory. */
uint8_t *app_picture_bytes(const app_picture *picture, float exposure, kd_tonemap curve);

/** Make the picture that `kandil run` would show: sRGB codes in floats. Errors NO_MEMORY with a message */
kd_status app_picture_encode(const app_picture *picture, float exposure, kd_tonemap curve, app_picture *out);

/** Write linear values in half floats. Errors as app_exr_write */
kd_status app_picture_write_exr(const char *path, const app_picture *picture);

/** Write sRGB codes: those of an encoded picture, those of a linear one by exposure and curve. Errors as
 * app_png_write */
kd_status app_picture_write_png(const char *path, const app_picture *picture, float exposure,
                                kd_tonemap curve);

/** Exposure factor that settings and picture give, as the renderer finds it. */
float app_picture_exposure(const app_picture *picture, const kd_settings *settings);

#endif
