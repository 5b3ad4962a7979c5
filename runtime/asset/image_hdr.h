#ifndef KD_ASSET_IMAGE_HDR_H
#define KD_ASSET_IMAGE_HDR_H

/* stb_image, its Radiance decoder only, behind two calls. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

bool image_hdr_measure(const uint8_t *bytes, int size, int *width, int *height);
/** Decode to width * height RGB floats, row 0 on top, which the caller frees with free(); NULL when the data
 * are broken or are cut off. */
float *image_hdr_decode(const uint8_t *bytes, int size, int *width, int *height);

#endif
