#ifndef KD_ASSET_EXR_SHIM_H
#define KD_ASSET_EXR_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One channel of a picture. */
typedef struct exr_plane {
    const char *name;
    bool floats;        /* 32 bits each, else halfs */
    const void *texels; /* row 0 on top */
} exr_plane;

/** Encode planes as OpenEXR, scan lines of one part, ZIP compressed. Their names are in the order of strcmp,
 * as readers expect.
 *
 *  Returns bytes in *data, which the caller frees with free(); 0 and NULL when that failed
 */
size_t exr_shim_encode(uint32_t width, uint32_t height, const exr_plane *planes, uint32_t count,
                       unsigned char **data);

/** Decode an OpenEXR file with channels R, G, B, or one channel, which is then taken three times.
 *
 *  Returns rows of RGB texels, row 0 on top, which the caller frees with free(); NULL with a static text in
 * *error
 */
float *exr_shim_decode(const void *data, size_t size, uint32_t *width, uint32_t *height, const char **error);

/** Decode channels of an OpenEXR file by their names.
 *
 *  Shapes  result: `count` planes of *height rows of *width values, row 0 on top
 *  Returns what the caller frees with free(); NULL with a static text in *error, and in *missing the first
 *          name that the file does not have, or NULL
 */
float *exr_shim_planes(const void *data, size_t size, const char *const *names, uint32_t count,
                       uint32_t *width, uint32_t *height, const char **error, const char **missing);

#ifdef __cplusplus
}
#endif

#endif
