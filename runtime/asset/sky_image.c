#include "runtime/asset/sky_image.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/asset/exr_shim.h"
#include "runtime/asset/image_hdr.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

enum { PIXELS_MAX = 1 << 27 }; /* 1.6 GB of floats */
static const size_t FILE_MAX = (size_t)1 << 30;

static kd_status decode_exr(const char *path, const uint8_t *bytes, size_t size, kd_sky_image *out)
{
    const char *error = NULL;
    out->rgb = exr_shim_decode(bytes, size, &out->width, &out->height, &error);
    if (out->rgb == NULL)
        return kd_fail(KD_BAD_FORMAT, "%s: %s; use another file", path, error);
    return KD_OK;
}

static kd_status decode_hdr(const char *path, const uint8_t *bytes, size_t size, kd_sky_image *out)
{
    int width, height;
    if (size > INT_MAX || !image_hdr_measure(bytes, (int)size, &width, &height) || width < 1 || height < 1)
        return kd_fail(KD_BAD_FORMAT, "%s: its header is damaged; use another file", path);
    if ((uint32_t)width > KD_SKY_SIDE_MAX || (uint32_t)height > KD_SKY_SIDE_MAX ||
        (int64_t)width * height > PIXELS_MAX)
        return kd_fail(KD_TOO_LARGE, "%s: %d x %d texels are too many for a sky; make it smaller", path,
                       width, height);
    out->rgb = image_hdr_decode(bytes, (int)size, &width, &height);
    if (out->rgb == NULL)
        return kd_fail(KD_BAD_FORMAT, "%s: its pixels are damaged or cut off; use another file", path);
    out->width = (uint32_t)width;
    out->height = (uint32_t)height;
    return KD_OK;
}

static kd_status decode(const char *path, const uint8_t *bytes, size_t size, kd_sky_image *out)
{
    if (size >= 4 && memcmp(bytes, "\x76\x2f\x31\x01", 4) == 0)
        return decode_exr(path, bytes, size, out);
    if (size >= 2 && memcmp(bytes, "#?", 2) == 0)
        return decode_hdr(path, bytes, size, out);
    return kd_fail(KD_UNSUPPORTED, "%s: is neither Radiance (.hdr) nor OpenEXR (.exr); convert it", path);
}

static void clean(const char *path, kd_sky_image *image)
{
    size_t count = (size_t)image->width * image->height * 3, bad = 0, bright = 0;
    for (size_t i = 0; i < count; i++) {
        float v = image->rgb[i];
        bool usable = v >= 0 && v < INFINITY; /* NaN fails too */
        bad += !usable;
        bright += usable && v > KD_SKY_RADIANCE_MAX;
        image->rgb[i] = usable ? fminf(v, KD_SKY_RADIANCE_MAX) : 0;
    }
    if (bad > 0)
        kd_log(KD_LOG_WARNING, "%s: %zu values are negative or no numbers; they count as black", path, bad);
    if (bright > 0)
        kd_log(KD_LOG_WARNING, "%s: %zu values are brighter than %g; they are cut to that", path, bright,
               (double)KD_SKY_RADIANCE_MAX);
}

/* Means of two by two, in place: each is written where nothing is read any more. An odd last row or column
 * goes. */
static void halve(kd_sky_image *image)
{
    uint32_t width = image->width / 2, height = image->height > 1 ? image->height / 2 : 1;
    size_t row = (size_t)image->width * 3, below = image->height > 1 ? row : 0;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            for (uint32_t c = 0; c < 3; c++) {
                const float *at = image->rgb + y * (row + below) + (size_t)x * 6 + c;
                image->rgb[((size_t)y * width + x) * 3 + c] =
                    0.25f * (at[0] + at[3] + at[below] + at[below + 3]);
            }
    image->width = width;
    image->height = height;
}

kd_status kd_sky_image_load(const char *path, kd_sky_image *out)
{
    void *data;
    size_t size;
    *out = (kd_sky_image){0};
    kd_status status = kd_file_read(path, FILE_MAX, &data, &size);
    if (status != KD_OK)
        return status;
    status = decode(path, data, size, out);
    free(data);
    if (status != KD_OK)
        return status;
    clean(path, out);
    while (out->width > KD_SKY_WIDTH_MAX || out->height > KD_SKY_WIDTH_MAX)
        halve(out);
    return KD_OK;
}

void kd_sky_image_fini(kd_sky_image *image)
{
    free(image->rgb);
    *image = (kd_sky_image){0};
}
