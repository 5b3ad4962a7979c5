#ifndef KD_APP_IMAGE_WRITE_H
#define KD_APP_IMAGE_WRITE_H

/* Picture files, written whole or not at all. Threading: any. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

/** Write an 8 bit sRGB file without opacity.
 *
 *  Shapes  rgba: height rows of width texels of 4 bytes, row 0 on top; opacity is left out
 *  Errors  as kd_file_out_open and kd_file_out_commit, NO_MEMORY; one message
 */
kd_status app_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba);

/** Write the same in 16 bits.
 *
 *  Shapes  rgba: height rows of width texels of 4 words, row 0 on top; opacity is left out
 *  Errors  as app_png_write
 */
kd_status app_png_write_deep(const char *path, uint32_t width, uint32_t height, const uint16_t *rgba);

/** Encode 8 bits, which the caller frees with free(). Errors  NO_MEMORY; one message */
kd_status app_png_encode(uint32_t width, uint32_t height, const uint8_t *rgba, void **data, size_t *size);

/** Write linear radiance in half floats, three channels, ZIP compressed.
 *
 *  Shapes  rgba: height rows of width texels of 4 halfs, row 0 on top; opacity is left out
 *  Errors  as kd_file_write, NO_MEMORY; one message
 */
kd_status app_exr_write(const char *path, uint32_t width, uint32_t height, const uint16_t *rgba);

/** Write the same of floats, cut to half floats. */
kd_status app_exr_write_floats(const char *path, uint32_t width, uint32_t height, const float *rgba);

/** Write a frame with its layers: the picture as R, G, B; direct, indirect, specular, emission, blended and
 * albedo as NAME.R, .G, .B; the normal as N.X, N.Y, N.Z; the depth as Z; motion.X and motion.Y.
 *
 *  Shapes  slices: KD_LAYER_COUNT pictures (shaders/shared/film.h) of 4 halfs, or floats, a texel
 *  Errors  as app_exr_write
 */
kd_status app_exr_write_layers(const char *path, uint32_t width, uint32_t height, const void *slices,
                               bool floats);

#endif
