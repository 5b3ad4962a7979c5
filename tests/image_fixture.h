#ifndef KD_TESTS_IMAGE_FIXTURE_H
#define KD_TESTS_IMAGE_FIXTURE_H

/* Pictures made by the program itself: a scenario is written to a folder of its own, `kandil` renders it, and
 * the PNG or EXR is read back. Included once, by the test's only source. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>
#include <spng.h>

#include "runtime/app/child.h"
#include "runtime/core/file.h"
#include "tests/image_exr.h"

typedef struct image {
    uint32_t width, height;
    float *rgb; /* row 0 on top; PNG: as stored, 0 to 1; EXR: linear radiance */
} image;

static char image_folder[64];
static char image_message[1024]; /* the last line that the program wrote to standard error */

/* ---- files ---- */

static int image_setup(void **state)
{
    (void)state;
    snprintf(image_folder, sizeof image_folder, "/tmp/kandil_image_XXXXXX");
    return mkdtemp(image_folder) ? 0 : -1;
}

/* The pictures go, unless KD_KEEP_PICTURES is set: then someone wants to look at them. */
static int image_teardown(void **state)
{
    char command[96];
    (void)state;
    if (getenv("KD_KEEP_PICTURES"))
        return 0;
    snprintf(command, sizeof command, "rm -rf '%s'", image_folder);
    return system(command);
}

/* A path in the test's folder; four can be in use at a time. */
static inline const char *image_path(const char *name)
{
    static char paths[4][256];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", image_folder, name);
    return path;
}

/* Write scenario `name` from a format. Returns its path. */
__attribute__((format(printf, 2, 3))) static inline const char *image_scenario(const char *name,
                                                                               const char *format, ...)
{
    static char text[16384];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    assert_in_range(length, 1, sizeof text - 1);
    assert_int_equal(kd_file_write(image_path(name), text, (size_t)length), KD_OK);
    return image_path(name);
}

/* ---- the program ---- */

static inline int image_run_all(const char *const *arguments)
{
    const char *argv[48] = {KD_BINARY_DIR "/kandil"};
    app_child child = {0};
    for (size_t i = 0; arguments[i]; i++) {
        assert_in_range(i, 0, 45);
        argv[i + 1] = arguments[i];
    }
    assert_int_equal(app_child_start(&child, argv), KD_OK);
    return app_child_finish(&child, image_message, sizeof image_message);
}

/* Run `kandil` with the arguments. Returns its exit code. */
#define image_kandil(...) image_run_all((const char *const[]){__VA_ARGS__, NULL})

/* The same; anything but success ends the test with the program's message. */
#define image_render(...)                                                                                    \
    do {                                                                                                     \
        int code_ = image_kandil("run", __VA_ARGS__, "--quiet");                                             \
        if (code_ != 0)                                                                                      \
            fail_msg("exit code %d: %s", code_, image_message);                                              \
    } while (0)

/* ---- reading ---- */

static inline image image_read_png(const char *path)
{
    struct spng_ihdr header;
    void *data;
    size_t size, bytes;
    assert_int_equal(kd_file_read(path, KD_FILE_NO_LIMIT, &data, &size), KD_OK);
    spng_ctx *png = spng_ctx_new(0);
    assert_non_null(png);
    assert_int_equal(spng_set_png_buffer(png, data, size), 0);
    assert_int_equal(spng_get_ihdr(png, &header), 0);
    assert_int_equal(spng_decoded_image_size(png, SPNG_FMT_RGB8, &bytes), 0);
    uint8_t *texels = malloc(bytes);
    image picture = {header.width, header.height, malloc(bytes * sizeof(float))};
    assert_true(texels && picture.rgb);
    assert_int_equal(spng_decode_image(png, texels, bytes, SPNG_FMT_RGB8, 0), 0);
    for (size_t i = 0; i < bytes; i++)
        picture.rgb[i] = (float)texels[i] / 255.0f;
    spng_ctx_free(png);
    free(texels);
    free(data);
    return picture;
}

static inline image image_read_exr(const char *path)
{
    image picture = {0};
    void *data;
    size_t size;
    assert_int_equal(kd_file_read(path, KD_FILE_NO_LIMIT, &data, &size), KD_OK);
    picture.rgb = image_exr_decode(data, size, &picture.width, &picture.height);
    assert_non_null(picture.rgb);
    free(data);
    return picture;
}

static inline image image_read(const char *name)
{
    const char *path = image_path(name);
    return kd_path_has_extension(path, ".png") ? image_read_png(path) : image_read_exr(path);
}

static inline void image_free(image *picture)
{
    free(picture->rgb);
    *picture = (image){0};
}

static inline void assert_same_file(const char *a, const char *b)
{
    void *data[2];
    size_t size[2];
    assert_int_equal(kd_file_read(image_path(a), KD_FILE_NO_LIMIT, &data[0], &size[0]), KD_OK);
    assert_int_equal(kd_file_read(image_path(b), KD_FILE_NO_LIMIT, &data[1], &size[1]), KD_OK);
    if (size[0] != size[1] || memcmp(data[0], data[1], size[0]) != 0)
        fail_msg("%s and %s differ", a, b);
    free(data[0]);
    free(data[1]);
}

/* ---- numbers ---- */

static inline size_t image_count(image p)
{
    return (size_t)p.width * p.height * 3;
}

static inline const float *image_at(image p, uint32_t x, uint32_t y)
{
    assert_true(x < p.width && y < p.height);
    return p.rgb + ((size_t)y * p.width + x) * 3;
}

/* Mean of one channel over the pixels x0 <= x < x1, y0 <= y < y1. */
static inline double image_mean(image p, int channel, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double sum = 0;
    for (uint32_t y = y0; y < y1; y++)
        for (uint32_t x = x0; x < x1; x++)
            sum += (double)image_at(p, x, y)[channel];
    return sum / ((double)(x1 - x0) * (y1 - y0));
}

static inline double image_mean_all(image p)
{
    double sum = 0;
    for (size_t i = 0; i < image_count(p); i++)
        sum += (double)p.rgb[i];
    return sum / (double)image_count(p);
}

static inline void assert_double_above(double value, double bound)
{
    if (!(value > bound))
        fail_msg("%g is not above %g", value, bound);
}

static inline void assert_double_below(double value, double bound)
{
    if (!(value < bound))
        fail_msg("%g is not below %g", value, bound);
}

static inline void assert_double_near(double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance))
        fail_msg("%g is not within %g of %g", value, tolerance, wanted);
}

typedef struct image_error {
    double mean, p99, max; /* of the absolute difference of texels' channels */
} image_error;

static inline int image_compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static inline image_error image_difference(image a, image b)
{
    size_t n = image_count(a);
    image_error e = {0};
    double *all = malloc(n * sizeof *all);
    assert_true(a.width == b.width && a.height == b.height && n > 0 && all);
    for (size_t i = 0; i < n; i++)
        e.mean += all[i] = fabs((double)a.rgb[i] - (double)b.rgb[i]);
    qsort(all, n, sizeof *all, image_compare_doubles);
    e.mean /= (double)n;
    e.p99 = all[(n - 1) * 99 / 100];
    e.max = all[n - 1];
    free(all);
    return e;
}

static inline bool image_is_constant(image p)
{
    for (size_t i = 3; i < image_count(p); i++)
        if (p.rgb[i] != p.rgb[i % 3])
            return false;
    return true;
}

#endif
