#ifndef KD_TESTS_IMAGE_EXR_H
#define KD_TESTS_IMAGE_EXR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Decode an OpenEXR file with channels R, G, B.
 *
 *  Returns height rows of width RGB texels, row 0 on top, which the caller frees; NULL when it is no such
 * file
 */
float *image_exr_decode(const void *data, size_t size, uint32_t *width, uint32_t *height);

#ifdef __cplusplus
}
#endif

#endif
