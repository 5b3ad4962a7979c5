#ifndef KD_ASSET_EXR_SHIM_H
#define KD_ASSET_EXR_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Encode three planes of halfs, in order B, G, R, as OpenEXR.
 *
 *  Returns bytes in *data, which the caller frees with free(); 0 and NULL when that failed
 */
size_t exr_shim_encode(uint32_t width, uint32_t height, const uint16_t *planes, unsigned char **data);

/** Decode an OpenEXR file with channels R, G, B, or one channel, which is then taken three times.
 *
 *  Returns rows of RGB texels, row 0 on top, which the caller frees with free(); NULL with a static text in
 * *error
 */
float *exr_shim_decode(const void *data, size_t size, uint32_t *width, uint32_t *height, const char **error);

#ifdef __cplusplus
}
#endif

#endif
