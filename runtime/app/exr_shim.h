#ifndef KD_APP_EXR_SHIM_H
#define KD_APP_EXR_SHIM_H

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

#ifdef __cplusplus
}
#endif

#endif
