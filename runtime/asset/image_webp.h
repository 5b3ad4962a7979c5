#ifndef KD_ASSET_IMAGE_WEBP_H
#define KD_ASSET_IMAGE_WEBP_H

/* Still pictures in WebP, through libwebp. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

bool image_is_webp(const uint8_t *bytes, size_t size);

/** Returns false when the header is broken. */
bool image_webp_measure(const uint8_t *bytes, size_t size, int *width, int *height);

/** Decode to RGBA, row 0 on top. Returns false when the data are broken or the size is not as measured. */
bool image_webp_decode(const uint8_t *bytes, size_t size, uint32_t width, uint32_t height, uint8_t *rgba);

#endif
