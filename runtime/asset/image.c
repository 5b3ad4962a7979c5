#include "runtime/asset/image.h"

#include <limits.h>
#include <stdbool.h>
#include <string.h>

#include <spng.h>

#include "runtime/asset/image_jpeg.h"
#include "runtime/asset/image_webp.h"

/* A chunk of text or colour profile larger than this is nothing a texture needs. */
#define PNG_CHUNK_MAX ((size_t)16 << 20)

static bool is_png(const uint8_t *bytes, size_t size)
{
    return size > 8 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0;
}

static bool is_jpeg(const uint8_t *bytes, size_t size)
{
    return size > 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0;
}

static spng_ctx *open_png(const uint8_t *bytes, size_t size)
{
    spng_ctx *png = spng_ctx_new(SPNG_CTX_IGNORE_ADLER32);
    if (!png)
        return NULL;
    if (spng_set_image_limits(png, IMAGE_SIDE_MAX, IMAGE_SIDE_MAX) ||
        spng_set_chunk_limits(png, PNG_CHUNK_MAX, PNG_CHUNK_MAX) || spng_set_png_buffer(png, bytes, size)) {
        spng_ctx_free(png);
        return NULL;
    }
    return png;
}

static kd_status measure_png(const uint8_t *bytes, size_t size, image_info *out, const char **error)
{
    *error = "out of memory";
    spng_ctx *png = open_png(bytes, size);
    if (!png)
        return KD_NO_MEMORY;
    struct spng_ihdr header;
    int code = spng_get_ihdr(png, &header);
    spng_ctx_free(png);
    *error = spng_strerror(code);
    if (code == SPNG_EUSER_WIDTH || code == SPNG_EUSER_HEIGHT) {
        *error = "the picture is wider or higher than 16384 pixels; make it smaller";
        return KD_TOO_LARGE;
    }
    if (code)
        return KD_BAD_FORMAT;
    *out = (image_info){header.width, header.height};
    return KD_OK;
}

kd_status image_measure(const uint8_t *bytes, size_t size, image_info *out, const char **error)
{
    if (is_png(bytes, size))
        return measure_png(bytes, size, out, error);
    bool webp = image_is_webp(bytes, size);
    if (!webp && !is_jpeg(bytes, size)) {
        *error = "the picture is neither PNG, JPEG nor WebP; convert it";
        return KD_UNSUPPORTED;
    }
    int width, height;
    *error = webp ? "the WebP header is broken" : "the JPEG header is broken";
    bool measured = size <= INT_MAX && (webp ? image_webp_measure(bytes, size, &width, &height)
                                             : image_jpeg_measure(bytes, (int)size, &width, &height));
    if (!measured || width < 1 || height < 1)
        return KD_BAD_FORMAT;
    *error = "the picture is wider or higher than 16384 pixels; make it smaller";
    if (width > (int)IMAGE_SIDE_MAX || height > (int)IMAGE_SIDE_MAX)
        return KD_TOO_LARGE;
    *out = (image_info){(uint32_t)width, (uint32_t)height};
    return KD_OK;
}

kd_status image_decode(const uint8_t *bytes, size_t size, const image_info *info, uint8_t *rgba,
                       const char **error)
{
    size_t out_bytes = (size_t)info->width * info->height * 4;
    if (is_jpeg(bytes, size)) {
        *error = "the JPEG data are broken or cut off";
        return image_jpeg_decode(bytes, (int)size, out_bytes, rgba) ? KD_OK : KD_BAD_FORMAT;
    }
    if (image_is_webp(bytes, size)) {
        *error = "the WebP data are broken or cut off";
        return image_webp_decode(bytes, size, info->width, info->height, rgba) ? KD_OK : KD_BAD_FORMAT;
    }
    *error = "out of memory";
    spng_ctx *png = open_png(bytes, size);
    if (!png)
        return KD_NO_MEMORY;
    int code = spng_decode_image(png, rgba, out_bytes, SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
    spng_ctx_free(png);
    *error = spng_strerror(code);
    return code ? KD_BAD_FORMAT : KD_OK;
}
