#include "runtime/app/image_write.h"

#include <spng.h>
#include <stdlib.h>

#include "runtime/asset/exr_shim.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

/* Encode row by row, so that a picture of any size needs one row beside it. Returns an spng error. */
static int encode_rows(spng_ctx *encoder, uint32_t width, uint32_t height, const uint8_t *rgba, uint8_t *row)
{
    int error =
        spng_encode_image(encoder, NULL, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
    for (uint32_t y = 0; y < height && error == 0; y++) {
        const uint8_t *from = rgba + (size_t)y * width * 4;
        for (size_t x = 0; x < width; x++) {
            row[x * 3] = from[x * 4];
            row[x * 3 + 1] = from[x * 4 + 1];
            row[x * 3 + 2] = from[x * 4 + 2];
        }
        error = spng_encode_row(encoder, row, (size_t)width * 3);
    }
    return error == SPNG_EOI ? 0 : error;
}

/* To the stream, or, when it is NULL, to memory that the caller frees. */
static int encode(FILE *stream, void **data, size_t *size, uint32_t width, uint32_t height,
                  const uint8_t *rgba, uint8_t *row)
{
    struct spng_ihdr header = {
        .width = width, .height = height, .bit_depth = 8, .color_type = SPNG_COLOR_TYPE_TRUECOLOR};
    spng_ctx *encoder = spng_ctx_new(SPNG_CTX_ENCODER);
    if (!encoder)
        return SPNG_EMEM;
    int error =
        stream ? spng_set_png_file(encoder, stream) : spng_set_option(encoder, SPNG_ENCODE_TO_BUFFER, 1);
    if (!error)
        error = spng_set_ihdr(encoder, &header);
    if (!error)
        error = spng_set_srgb(encoder, 0); /* perceptual */
    if (!error)
        error = spng_set_option(encoder, SPNG_IMG_COMPRESSION_LEVEL,
                                4); /* a third of level 6's time, 5 % larger */
    if (!error)
        error = encode_rows(encoder, width, height, rgba, row);
    if (!error && !stream)
        *data = spng_get_png_buffer(encoder, size, &error);
    spng_ctx_free(encoder);
    return error;
}

kd_status app_png_encode(uint32_t width, uint32_t height, const uint8_t *rgba, void **data, size_t *size)
{
    uint8_t *row = malloc((size_t)width * 3);
    int error = row ? encode(NULL, data, size, width, height, rgba, row) : SPNG_EMEM;
    free(row);
    if (error)
        return kd_fail(KD_NO_MEMORY, "a picture of %ux%u could not be encoded (%s); choose another size",
                       width, height, spng_strerror(error));
    return KD_OK;
}

kd_status app_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba)
{
    kd_file_out file;
    kd_status status = kd_file_out_open(&file, path);
    if (status != KD_OK)
        return status;
    uint8_t *row = malloc((size_t)width * 3);
    int error = row ? encode(file.stream, NULL, NULL, width, height, rgba, row) : SPNG_EMEM;
    free(row);
    if (error && error != SPNG_IO_ERROR) {
        kd_file_out_cancel(&file);
        return kd_fail(error == SPNG_EMEM ? KD_NO_MEMORY : KD_IO,
                       "%s: the picture could not be encoded (%s); choose another size", path,
                       spng_strerror(error));
    }
    return kd_file_out_commit(&file); /* which also says what went wrong with the stream */
}

kd_status app_exr_write(const char *path, uint32_t width, uint32_t height, const uint16_t *rgba)
{
    unsigned char *data = NULL;
    size_t count = (size_t)width * height, size = 0;
    uint16_t *planes = malloc(count * 3 * sizeof *planes);
    if (planes) {
        for (size_t i = 0; i < count; i++) {
            planes[i] = rgba[i * 4 + 2];
            planes[count + i] = rgba[i * 4 + 1];
            planes[count * 2 + i] = rgba[i * 4];
        }
        size = exr_shim_encode(width, height, planes, &data);
        free(planes);
    }
    if (!data)
        return kd_fail(KD_NO_MEMORY, "%s: the picture could not be encoded; choose a smaller size", path);
    kd_status status = kd_file_write(path, data, size);
    free(data);
    return status;
}
