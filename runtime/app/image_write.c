#include "runtime/app/image_write.h"

#include <spng.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/file.h"
#include "runtime/core/log.h"

/* A picture to encode: four bytes a texel, or four words. */
typedef struct png_source {
    uint32_t width, height;
    const void *rgba;
    bool deep;
} png_source;

static size_t row_bytes(const png_source *p)
{
    return (size_t)p->width * 3 * (p->deep ? 2 : 1);
}

/* Leave opacity out. */
static void pack_row(const png_source *p, uint32_t y, uint8_t *row)
{
    size_t channel = p->deep ? 2 : 1;
    const uint8_t *from = (const uint8_t *)p->rgba + (size_t)y * p->width * 4 * channel;
    for (size_t x = 0; x < p->width; x++)
        memcpy(row + x * 3 * channel, from + x * 4 * channel, 3 * channel);
}

/* Encode row by row, so that a picture of any size needs one row beside it. Returns an spng error. */
static int encode_rows(spng_ctx *encoder, const png_source *p, uint8_t *row)
{
    int error =
        spng_encode_image(encoder, NULL, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
    for (uint32_t y = 0; y < p->height && error == 0; y++) {
        pack_row(p, y, row);
        error = spng_encode_row(encoder, row, row_bytes(p));
    }
    return error == SPNG_EOI ? 0 : error;
}

/* To the stream, or, when it is NULL, to memory that the caller frees. */
static int encode(FILE *stream, void **data, size_t *size, const png_source *p)
{
    struct spng_ihdr header = {.width = p->width,
                               .height = p->height,
                               .bit_depth = p->deep ? 16 : 8,
                               .color_type = SPNG_COLOR_TYPE_TRUECOLOR};
    spng_ctx *encoder = spng_ctx_new(SPNG_CTX_ENCODER);
    uint8_t *row = malloc(row_bytes(p));
    int error = encoder && row ? 0 : SPNG_EMEM;
    if (!error)
        error =
            stream ? spng_set_png_file(encoder, stream) : spng_set_option(encoder, SPNG_ENCODE_TO_BUFFER, 1);
    if (!error)
        error = spng_set_ihdr(encoder, &header);
    if (!error)
        error = spng_set_srgb(encoder, 0); /* perceptual */
    if (!error)
        error = spng_set_option(encoder, SPNG_IMG_COMPRESSION_LEVEL,
                                4); /* a third of level 6's time, 5 % larger */
    if (!error)
        error = encode_rows(encoder, p, row);
    if (!error && !stream)
        *data = spng_get_png_buffer(encoder, size, &error);
    spng_ctx_free(encoder);
    free(row);
    return error;
}

kd_status app_png_encode(uint32_t width, uint32_t height, const uint8_t *rgba, void **data, size_t *size)
{
    int error = encode(NULL, data, size, &(png_source){width, height, rgba, false});
    if (error)
        return kd_fail(KD_NO_MEMORY, "a picture of %ux%u could not be encoded (%s); choose another size",
                       width, height, spng_strerror(error));
    return KD_OK;
}

static kd_status write_png(const char *path, const png_source *p)
{
    kd_file_out file;
    kd_status status = kd_file_out_open(&file, path);
    if (status != KD_OK)
        return status;
    int error = encode(file.stream, NULL, NULL, p);
    /* After a failed write the encoder may name its own state, not the cause: the stream knows better. */
    if (error && error != SPNG_IO_ERROR && !ferror(file.stream)) {
        kd_file_out_cancel(&file);
        return kd_fail(error == SPNG_EMEM ? KD_NO_MEMORY : KD_IO,
                       "%s: the picture could not be encoded (%s); choose another size", path,
                       spng_strerror(error));
    }
    return kd_file_out_commit(&file); /* which also says what went wrong with the stream */
}

kd_status app_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba)
{
    return write_png(path, &(png_source){width, height, rgba, false});
}

kd_status app_png_write_deep(const char *path, uint32_t width, uint32_t height, const uint16_t *rgba)
{
    return write_png(path, &(png_source){width, height, rgba, true});
}
