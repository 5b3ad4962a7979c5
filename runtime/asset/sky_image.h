#ifndef KD_ASSET_SKY_IMAGE_H
#define KD_ASSET_SKY_IMAGE_H

/* Pictures of a whole sky: Radiance (.hdr) and OpenEXR (.exr) files in equirectangular projection, told apart
 * by their first bytes. */

#include <stdint.h>

#include "runtime/core/status.h"

#define KD_SKY_SIDE_MAX     16384u /* of a file */
#define KD_SKY_WIDTH_MAX    4096u  /* what is kept; wider pictures are halved until they fit */
#define KD_SKY_RADIANCE_MAX 1e9f

typedef struct kd_sky_image {
    uint32_t width, height;
    float *rgb; /* height rows of width linear RGB texels, row 0 (straight up) on top; finite, 0 … 1e9 */
} kd_sky_image;

/** Read a file. What is not a number or below zero counts as black, what is brighter than a sun is
 * cut; either is a warning.
 *
 *  Errors  as kd_file_read; UNSUPPORTED for other formats, BAD_FORMAT for damaged or cut files, TOO_LARGE,
 *          NO_MEMORY; one message
 *  Owns    kd_sky_image_fini frees
 */
kd_status kd_sky_image_load(const char *path, kd_sky_image *out);
void kd_sky_image_fini(kd_sky_image *image);

#endif
