#ifndef KD_ASSET_IMAGE_H
#define KD_ASSET_IMAGE_H

/* Pictures of a model: PNG through libspng, JPEG through stb_image, WebP through libwebp, told apart by their
 * first bytes. */

#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

/* The largest 2D texture every OpenGL 4.5 driver takes. */
#define IMAGE_SIDE_MAX 16384u

typedef struct image_info {
    uint32_t width, height;
} image_info;

/** Read the size from the header. Errors KD_UNSUPPORTED for other formats, KD_BAD_FORMAT, KD_TOO_LARGE;
 * `*error` then points to a static text, and no message is logged. */
kd_status image_measure(const uint8_t *bytes, size_t size, image_info *out, const char **error);

/** Decode to RGBA with 8 bits, row 0 on top.
 *
 *  Shapes  rgba: width * height * 4 bytes as measured
 *  Errors  KD_BAD_FORMAT, KD_NO_MEMORY, as above
 */
kd_status image_decode(const uint8_t *bytes, size_t size, const image_info *info, uint8_t *rgba,
                       const char **error);

#endif
