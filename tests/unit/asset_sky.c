/* Pictures of skies: what is read, and what is refused with a message that names the file. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/asset/exr_shim.h"
#include "runtime/asset/sky_image.h"
#include "runtime/core/file.h"
#include "runtime/core/half.h"
#include "runtime/core/log.h"
#include "tests/folder_fixture.h"

static char messages[2048];
static int warnings, errors;

static void collect(void *user, kd_log_level level, const char *text)
{
    (void)user;
    warnings += level == KD_LOG_WARNING;
    errors += level == KD_LOG_ERROR;
    snprintf(messages, sizeof messages, "%s", text);
}

static int begin(void **state)
{
    (void)state;
    kd_log_set_sink(collect, NULL);
    messages[0] = 0;
    warnings = errors = 0;
    return 0;
}

static int end(void **state)
{
    (void)state;
    kd_log_set_sink(NULL, NULL);
    return 0;
}

/* Flat RGBE: mantissas of 128 with exponent 129 are 1, 64 is 0.5, 0 is 0. */
static size_t make_hdr(uint8_t *out, size_t room, int width, int height)
{
    int n = snprintf((char *)out, room, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height, width);
    for (int i = 0; i < width * height; i++) {
        const uint8_t texel[4] = {128, 64, (uint8_t)(i == 1 ? 255 : 0), 129};
        memcpy(out + n, texel, 4);
        n += 4;
    }
    return (size_t)n;
}

/* Planes B, G, R of one value each but for the first red texel, a half float. */
static size_t make_exr(unsigned char **out, uint16_t first)
{
    uint16_t planes[3 * 8];
    const exr_plane named[] = {{"B", false, planes}, {"G", false, planes + 8}, {"R", false, planes + 16}};
    for (int i = 0; i < 24; i++)
        planes[i] = i == 16 ? first : kd_half_from_float(0.25f * (float)(i / 8));
    return exr_shim_encode(4, 2, named, 3, out);
}

static kd_status load_bytes(const void *bytes, size_t size, kd_sky_image *out)
{
    assert_int_equal(kd_file_write("sky", bytes, size), KD_OK);
    return kd_sky_image_load("sky", out);
}

static void refused(kd_status status, kd_status expected)
{
    assert_int_equal(status, expected);
    assert_int_equal(errors, 1);
    assert_non_null(strstr(messages, "sky"));
}

static void radiance_files_are_read(void **state)
{
    uint8_t bytes[512];
    kd_sky_image image;
    (void)state;
    assert_int_equal(load_bytes(bytes, make_hdr(bytes, sizeof bytes, 4, 2), &image), KD_OK);
    assert_true(image.width == 4 && image.height == 2);
    for (int i = 0; i < 8; i++) {
        assert_float_equal(image.rgb[i * 3], 1, 0);
        assert_float_equal(image.rgb[i * 3 + 1], 0.5f, 0);
        assert_float_equal(image.rgb[i * 3 + 2], i == 1 ? 255.0f / 128 : 0, 0);
    }
    assert_int_equal(warnings + errors, 0);
    kd_sky_image_fini(&image);
}

static void openexr_files_are_read(void **state)
{
    unsigned char *bytes;
    kd_sky_image image;
    (void)state;
    size_t size = make_exr(&bytes, 0x4200); /* 3 */
    assert_int_equal(load_bytes(bytes, size, &image), KD_OK);
    assert_true(image.width == 4 && image.height == 2);
    assert_float_equal(image.rgb[0], 3, 0);
    assert_float_equal(image.rgb[1], 0.25f, 0);
    assert_float_equal(image.rgb[3], 0.5f, 0);
    kd_sky_image_fini(&image);
    free(bytes);
}

static void what_is_no_number_counts_as_black(void **state)
{
    static const uint16_t values[3] = {0x7e00, 0x7c00, 0xbc00}; /* NaN, infinity, -1 */
    (void)state;
    for (int i = 0; i < 3; i++) {
        unsigned char *bytes;
        kd_sky_image image;
        size_t size = make_exr(&bytes, values[i]);
        warnings = 0;
        assert_int_equal(load_bytes(bytes, size, &image), KD_OK);
        assert_float_equal(image.rgb[0], 0, 0);
        assert_float_equal(image.rgb[3], 0.5f, 0);
        assert_int_equal(warnings, 1);
        kd_sky_image_fini(&image);
        free(bytes);
    }
}

static void missing_and_foreign_files_are_refused(void **state)
{
    kd_sky_image image;
    (void)state;
    refused(kd_sky_image_load("no_sky", &image), KD_NOT_FOUND);
    errors = 0;
    refused(load_bytes("\x89PNG\r\n\x1a\n picture", 16, &image), KD_UNSUPPORTED);
    errors = 0;
    refused(load_bytes("", 0, &image), KD_UNSUPPORTED);
    assert_null(image.rgb);
}

/* Each length is a file of its own, so that a sanitizer sees a read beyond its end. */
static void files_that_are_cut_off_are_refused(void **state)
{
    uint8_t hdr[512];
    unsigned char *exr;
    kd_sky_image image;
    (void)state;
    size_t hdr_size = make_hdr(hdr, sizeof hdr, 4, 2), exr_size = make_exr(&exr, 0x3c00);
    for (size_t size = 2; size < hdr_size; size++) {
        errors = 0;
        refused(load_bytes(hdr, size, &image), KD_BAD_FORMAT);
    }
    for (size_t size = 4; size < exr_size; size++) {
        errors = 0;
        refused(load_bytes(exr, size, &image), KD_BAD_FORMAT);
    }
    free(exr);
}

static void sizes_beyond_all_bounds_are_refused(void **state)
{
    static const char *const sizes[] = {"-Y 100000 +X 100000", "-Y 16385 +X 1", "-Y 16000 +X 16000",
                                        "-Y 0 +X 4", "-Y -2 +X 4"};
    (void)state;
    for (int i = 0; i < 5; i++) {
        char text[128];
        kd_sky_image image;
        int n = snprintf(text, sizeof text, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n%s\n", sizes[i]);
        errors = 0;
        refused(load_bytes(text, (size_t)n, &image), i < 3 ? KD_TOO_LARGE : KD_BAD_FORMAT);
    }
}

/* 8192 texels a row are halved once: pairs of the same value keep it. */
static void wide_pictures_are_halved(void **state)
{
    enum { WIDTH = 8192 };
    kd_sky_image image;
    (void)state;
    uint8_t *bytes = malloc(WIDTH * 4 + 128);
    assert_non_null(bytes);
    int n = snprintf((char *)bytes, 128, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X %d\n", WIDTH);
    for (int x = 0; x < WIDTH; x++, n += 4) {
        const uint8_t texel[4] = {(uint8_t)(128 + x / 2 % 64), 0, 0, 129};
        memcpy(bytes + n, texel, 4);
    }
    /* Rows of 8 to 32767 texels that begin so would be run-length coded: these begin with 128, not with 2. */
    assert_int_equal(load_bytes(bytes, (size_t)n, &image), KD_OK);
    assert_true(image.width == WIDTH / 2 && image.height == 1);
    for (int x = 0; x < WIDTH / 2; x++)
        assert_float_equal(image.rgb[x * 3], (float)(128 + x % 64) / 128, 0);
    kd_sky_image_fini(&image);
    free(bytes);
}

#define SKY_TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        SKY_TEST(radiance_files_are_read),
        SKY_TEST(openexr_files_are_read),
        SKY_TEST(what_is_no_number_counts_as_black),
        SKY_TEST(missing_and_foreign_files_are_refused),
        SKY_TEST(files_that_are_cut_off_are_refused),
        SKY_TEST(sizes_beyond_all_bounds_are_refused),
        SKY_TEST(wide_pictures_are_halved),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
