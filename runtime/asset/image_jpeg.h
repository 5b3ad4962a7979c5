#ifndef KD_ASSET_IMAGE_JPEG_H
#define KD_ASSET_IMAGE_JPEG_H

/* stb_image, its JPEG decoder only, behind two calls. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

bool image_jpeg_measure(const uint8_t *bytes, int size, int *width, int *height);
/** Decode to RGBA; false when the data are broken or do not give exactly rgba_bytes. */
bool image_jpeg_decode(const uint8_t *bytes, int size, size_t rgba_bytes, uint8_t *rgba);

#endif
