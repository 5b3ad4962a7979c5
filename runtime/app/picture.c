#include "runtime/app/picture.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/asset/exr_shim.h"
#include "runtime/app/image_write.h"
#include "runtime/asset/image.h"
#include "runtime/core/color.h"
#include "runtime/core/file.h"
#include "runtime/core/half.h"
#include "runtime/core/log.h"

kd_status app_picture_make(app_picture *out, uint32_t width, uint32_t height)
{
    *out = (app_picture){.width = width, .height = height};
    out->rgb = calloc((size_t)width * height, 3 * sizeof *out->rgb);
    return out->rgb ? KD_OK
                    : kd_fail(KD_NO_MEMORY, "no memory for a picture of %ux%u; choose a smaller size", width,
                              height);
}

void app_picture_fini(app_picture *picture)
{
    free(picture->rgb);
    *picture = (app_picture){0};
}

kd_status app_picture_write_exr(const char *path, const app_picture *p)
{
    size_t count = (size_t)p->width * p->height;
    uint16_t *half = malloc(count * 4 * sizeof *half);
    if (!half)
        return kd_fail(KD_NO_MEMORY, "%s: no memory to encode the picture; choose a smaller size", path);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < 3; k++)
            half[i * 4 + k] = kd_half_from_float(p->rgb[i * 3 + k]);
        half[i * 4 + 3] = kd_half_from_float(1);
    }
    kd_status status = app_exr_write(path, p->width, p->height, half);
    free(half);
    return status;
}

static kd_vec3 texel(const app_picture *p, size_t i)
{
    return (kd_vec3){p->rgb[i * 3], p->rgb[i * 3 + 1], p->rgb[i * 3 + 2]};
}

uint8_t *app_picture_bytes(const app_picture *p, float exposure, kd_tonemap curve)
{
    size_t count = (size_t)p->width * p->height;
    uint8_t *bytes = malloc(count * 4);
    for (size_t i = 0; bytes && i < count; i++) {
        kd_vec3 c = p->encoded ? texel(p, i) : kd_color_screen(texel(p, i), exposure, curve);
        const uint8_t rgba[4] = {kd_color_byte(c.x), kd_color_byte(c.y), kd_color_byte(c.z), 255};
        memcpy(bytes + i * 4, rgba, sizeof rgba);
    }
    return bytes;
}

kd_status app_picture_write_png(const char *path, const app_picture *p, float exposure, kd_tonemap curve)
{
    uint8_t *bytes = app_picture_bytes(p, exposure, curve);
    if (!bytes)
        return kd_fail(KD_NO_MEMORY, "%s: no memory to encode the picture; choose a smaller size", path);
    kd_status status = app_png_write(path, p->width, p->height, bytes);
    free(bytes);
    return status;
}

/* Codes are rounded to bytes, as what is saved and shown. */
kd_status app_picture_encode(const app_picture *p, float exposure, kd_tonemap curve, app_picture *out)
{
    kd_status status = app_picture_make(out, p->width, p->height);
    uint8_t *bytes = status == KD_OK ? app_picture_bytes(p, exposure, curve) : NULL;
    if (status == KD_OK && !bytes)
        status = kd_fail(KD_NO_MEMORY, "no memory for a picture of %ux%u; choose a smaller size", p->width,
                         p->height);
    for (size_t i = 0; bytes && i < (size_t)p->width * p->height; i++)
        for (size_t k = 0; k < 3; k++)
            out->rgb[i * 3 + k] = (float)bytes[i * 4 + k] / 255;
    out->encoded = true;
    free(bytes);
    return status;
}

/* shaders/resolve/luminance.comp and exposure.comp: the geometric mean of what is not black becomes mid grey.
 * Source  Reinhard et al. 2002, equations 1 and 2 */
float app_picture_exposure(const app_picture *p, const kd_settings *settings)
{
    const double mid_grey = 0.18;
    double sum = 0, count = 0;
    float chosen = exp2f(settings->view_exposure_ev);
    if (!settings->view_auto_exposure)
        return chosen;
    for (size_t i = 0; i < (size_t)p->width * p->height; i++) {
        float y = kd_color_luminance(texel(p, i));
        if (y > 1e-6f) {
            sum += log2((double)y);
            count++;
        }
    }
    return count > 0 ? chosen * (float)(mid_grey * exp2(-sum / count)) : chosen;
}

/* ---- reading ---- */

static kd_status read_exr(const char *path, const void *data, size_t size, app_picture *out)
{
    const char *error;
    out->rgb = exr_shim_decode(data, size, &out->width, &out->height, &error);
    return out->rgb ? KD_OK
                    : kd_fail(KD_BAD_FORMAT, "%s: %s; give an .exr of one part with channels R, G, B", path,
                              error);
}

static kd_status read_png(const char *path, const void *data, size_t size, app_picture *out)
{
    const char *error = "there is no memory to decode it";
    image_info info;
    uint8_t *bytes = NULL;
    kd_status status = image_measure(data, size, &info, &error);
    if (status == KD_OK && !(bytes = malloc((size_t)info.width * info.height * 4)))
        status = KD_NO_MEMORY;
    if (status == KD_OK)
        status = image_decode(data, size, &info, bytes, &error);
    if (status != KD_OK) {
        free(bytes);
        return kd_fail(status, "%s: %s; give a .png or .exr file", path, error);
    }
    status = app_picture_make(out, info.width, info.height);
    for (size_t i = 0; status == KD_OK && i < (size_t)info.width * info.height; i++)
        for (size_t k = 0; k < 3; k++)
            out->rgb[i * 3 + k] = (float)bytes[i * 4 + k] / 255;
    out->encoded = true;
    free(bytes);
    return status;
}

static kd_status check_finite(const char *path, const app_picture *p)
{
    for (size_t i = 0; i < (size_t)p->width * p->height * 3; i++)
        if (!isfinite(p->rgb[i]))
            return kd_fail(KD_BAD_FORMAT,
                           "%s: the value of pixel %zu, %zu is not finite; correct the picture", path,
                           i / 3 % p->width, i / 3 / p->width);
    return KD_OK;
}

/* ---- whether a file was written to its end ---- */

static bool png_is_whole(FILE *file)
{
    static const char first[8] = "\x89PNG\r\n\x1a\n", last[12] = "\0\0\0\0IEND\xae\x42\x60\x82";
    char head[sizeof first], end[sizeof last];
    return fread(head, 1, sizeof head, file) == sizeof head && memcmp(head, first, sizeof head) == 0 &&
           fseek(file, -(long)sizeof end, SEEK_END) == 0 && fread(end, 1, sizeof end, file) == sizeof end &&
           memcmp(end, last, sizeof end) == 0;
}

static uint64_t little_endian(const uint8_t *bytes, int count)
{
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; i--)
        value = value << 8 | bytes[i];
    return value;
}

/* Where the header's attributes end: each is a name, a type, a size and so many bytes. 0: not in these bytes */
static size_t exr_header_end(const uint8_t *bytes, size_t size)
{
    size_t at = 8; /* the format's number and version */
    while (at < size && bytes[at]) {
        for (int text = 0; text < 2; text++) {
            const uint8_t *zero = memchr(bytes + at, 0, size - at);
            if (!zero)
                return 0;
            at = (size_t)(zero - bytes) + 1;
        }
        if (size - at < 4)
            return 0;
        size_t value = (size_t)little_endian(bytes + at, 4);
        if (value > size - at - 4)
            return 0;
        at += 4 + value;
    }
    return at < size ? at + 1 : 0;
}

/* Behind the header stands a table of where blocks of lines begin, and the first begins behind it. The last one
 * ends the file: its line and its size, 4 bytes each, and so many bytes. */
static bool exr_is_whole(FILE *file)
{
    static const char first[4] = "\x76\x2f\x31\x01";
    static uint8_t header[65536];
    uint8_t row[8];
    size_t size = fread(header, 1, sizeof header, file);
    size_t table = size > 8 && memcmp(header, first, sizeof first) == 0 ? exr_header_end(header, size) : 0;
    if (!table || size - table < 8)
        return false;
    uint64_t begin = little_endian(header + table, 8);
    if (begin < table + 8 || begin > INT32_MAX || fseek(file, (long)begin - 8, SEEK_SET) != 0 ||
        fread(row, 1, 8, file) != 8)
        return false;
    uint64_t last = little_endian(row, 8);
    if (last < begin || last > (uint64_t)LONG_MAX / 2 || fseek(file, (long)last, SEEK_SET) != 0 ||
        fread(row, 1, 8, file) != 8)
        return false;
    return fseek(file, 0, SEEK_END) == 0 && (uint64_t)ftell(file) == last + 8 + little_endian(row + 4, 4);
}

bool app_picture_is_whole(const char *path)
{
    FILE *file = kd_file_exists(path) ? fopen(path, "rb") : NULL;
    if (!file)
        return false;
    bool whole = kd_path_has_extension(path, ".exr") ? exr_is_whole(file) : png_is_whole(file);
    fclose(file);
    return whole;
}

kd_status app_picture_read(const char *path, app_picture *out)
{
    void *data;
    size_t size;
    *out = (app_picture){0};
    kd_status status = kd_file_read(path, (size_t)1 << 31, &data, &size);
    if (status != KD_OK)
        return status;
    status = kd_path_has_extension(path, ".exr") ? read_exr(path, data, size, out)
                                                 : read_png(path, data, size, out);
    free(data);
    if (status == KD_OK)
        status = check_finite(path, out);
    if (status != KD_OK)
        app_picture_fini(out);
    return status;
}
