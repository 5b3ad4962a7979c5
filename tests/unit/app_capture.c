/* Files that the program writes: pixels come back as they went in, films have every frame, and nothing half
 * written stays. */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <spng.h>

#include "runtime/app/capture.h"
#include "runtime/app/film.h"
#include "runtime/app/image_write.h"
#include "runtime/app/picture.h"
#include "runtime/core/log.h"

static char folder[64];
static char last_message[2048];
static int message_count;

static void remember(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    snprintf(last_message, sizeof last_message, "%s", text);
    message_count++;
}

static const char *in_folder(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int open_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/kandil-capture-XXXXXX");
    kd_log_set_sink(remember, NULL);
    return mkdtemp(folder) ? 0 : -1;
}

static int close_folder(void **state)
{
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

/* Texels that differ everywhere, opacity included, which must not be stored. */
static uint8_t *make_texels(uint32_t width, uint32_t height)
{
    uint8_t *texels = malloc((size_t)width * height * 4);
    assert_non_null(texels);
    for (size_t i = 0; i < (size_t)width * height * 4; i++)
        texels[i] = (uint8_t)((i * 2654435761u) >> 13);
    return texels;
}

static void decode(const char *path, struct spng_ihdr *header, uint8_t **rgb)
{
    size_t size;
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    spng_ctx *decoder = spng_ctx_new(0);
    assert_int_equal(spng_set_png_file(decoder, file), 0);
    assert_int_equal(spng_get_ihdr(decoder, header), 0);
    assert_int_equal(spng_decoded_image_size(decoder, SPNG_FMT_RGB8, &size), 0);
    *rgb = malloc(size);
    assert_int_equal(spng_decode_image(decoder, *rgb, size, SPNG_FMT_RGB8, 0), 0);
    spng_ctx_free(decoder);
    fclose(file);
}

static void png_holds_the_pixels(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {64, 48}, {4096, 2}, {1, 300}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct spng_ihdr header;
        uint32_t width = sizes[i][0], height = sizes[i][1];
        uint8_t *texels = make_texels(width, height), *rgb;
        assert_int_equal(app_png_write(in_folder("a.png"), width, height, texels), KD_OK);
        decode(in_folder("a.png"), &header, &rgb);
        assert_true(header.width == width && header.height == height && header.bit_depth == 8);
        assert_int_equal(header.color_type, SPNG_COLOR_TYPE_TRUECOLOR);
        for (size_t p = 0; p < (size_t)width * height; p++)
            assert_memory_equal(rgb + p * 3, texels + p * 4, 3);
        free(rgb);
        free(texels);
    }
}

static void a_failed_picture_leaves_nothing(void **state)
{
    (void)state;
    uint8_t texel[4] = {1, 2, 3, 4};
    uint16_t half[4] = {0x3C00, 0x3C00, 0x3C00, 0x3C00};
    message_count = 0;
    assert_int_not_equal(app_png_write(in_folder("missing/a.png"), 1, 1, texel), KD_OK);
    assert_int_equal(message_count, 1);
    assert_int_not_equal(app_exr_write(in_folder("missing/a.exr"), 1, 1, half), KD_OK);
    assert_int_equal(message_count, 2);
    assert_int_equal(access(in_folder("missing"), F_OK), -1);
}

/* A limit on the size of files stands for a disk that fills up: at once, mid-picture, at the last bytes. */
static void a_picture_without_space_says_so(void **state)
{
    (void)state;
    struct rlimit before, small;
    struct stat whole;
    uint8_t *texels = make_texels(320, 180);
    assert_int_equal(app_png_write(in_folder("full.png"), 320, 180, texels), KD_OK);
    assert_int_equal(stat(in_folder("full.png"), &whole), 0);
    unlink(in_folder("full.png"));
    const rlim_t limits[] = {0, 1000, 5000, (rlim_t)whole.st_size / 2, (rlim_t)whole.st_size - 1};
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        small = (struct rlimit){.rlim_cur = limits[i], .rlim_max = before.rlim_max};
        message_count = 0;
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        kd_status status = app_png_write(in_folder("full.png"), 320, 180, texels);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_int_equal(status, KD_DISK_FULL);
        assert_int_equal(message_count, 1);
        assert_non_null(strstr(last_message, "full.png: no space left"));
        assert_int_equal(access(in_folder("full.png"), F_OK), -1);
    }
    assert_int_equal(app_png_write("/dev/full", 320, 180, texels), KD_DISK_FULL);
    assert_int_equal(app_png_write("/dev/full", 1, 1, texels), KD_DISK_FULL); /* noticed at the flush */
    assert_int_equal(app_png_write_deep("/dev/full", 160, 180, (const uint16_t *)(const void *)texels),
                     KD_DISK_FULL);
    free(texels);
}

static void exr_is_half_floats_in_three_channels(void **state)
{
    (void)state;
    uint16_t texels[2 * 4] = {0x3C00, 0x4000, 0x4200, 0x7BFF, 0x0000, 0x3800, 0xBC00, 0x0000};
    char head[8];
    assert_int_equal(app_exr_write(in_folder("a.exr"), 2, 1, texels), KD_OK);
    FILE *file = fopen(in_folder("a.exr"), "rb");
    assert_non_null(file);
    assert_int_equal(fread(head, 1, 8, file), 8);
    fclose(file);
    assert_memory_equal(head, "\x76\x2f\x31\x01\x02\x00\x00\x00",
                        8); /* magic number, version 2, single part scan lines */
}

static void only_whole_pictures_are_finished(void **state)
{
    (void)state;
    struct stat info;
    uint8_t *texels = make_texels(16, 16);
    const uint16_t half[4] = {0x3C00, 0x3C00, 0x3C00, 0x3C00};
    message_count = 0;
    assert_false(app_picture_is_whole(in_folder("none.png")));
    assert_false(app_picture_is_whole(folder));
    assert_int_equal(app_png_write(in_folder("part.png"), 16, 16, texels), KD_OK);
    assert_true(app_picture_is_whole(in_folder("part.png")));
    assert_int_equal(stat(in_folder("part.png"), &info), 0);
    const off_t sizes[] = {info.st_size - 1, info.st_size - 12, info.st_size / 2, 8, 1, 0};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        assert_int_equal(truncate(in_folder("part.png"), sizes[i]), 0);
        assert_false(app_picture_is_whole(in_folder("part.png")));
    }
    assert_int_equal(app_exr_write(in_folder("part.exr"), 1, 1, half), KD_OK);
    assert_true(app_picture_is_whole(in_folder("part.exr")));
    assert_int_equal(truncate(in_folder("part.exr"), 3), 0);
    assert_false(app_picture_is_whole(in_folder("part.exr")));
    assert_int_equal(message_count, 0);
    free(texels);
}

static int count_film_frames(const char *path)
{
    char command[512];
    int frames = -1;
    snprintf(command, sizeof command,
             "ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames -of "
             "csv=p=0 '%s'",
             path);
    FILE *out = popen(command, "r");
    assert_non_null(out);
    if (fscanf(out, "%d", &frames) != 1)
        frames = -1;
    pclose(out);
    return frames;
}

static void films_have_every_frame(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{64, 48}, {33, 17}, {1, 1}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        app_film film;
        uint8_t *texels = make_texels(sizes[i][0], sizes[i][1]);
        assert_int_equal(app_film_open(&film, in_folder("a b.mp4"), sizes[i][0], sizes[i][1], 24), KD_OK);
        assert_int_equal(access(in_folder("a b.mp4"), F_OK), i ? 0 : -1); /* it appears when it is whole */
        for (int frame = 0; frame < 7; frame++)
            assert_int_equal(app_film_write(&film, texels), KD_OK);
        assert_int_equal(app_film_close(&film), KD_OK);
        assert_int_equal(count_film_frames(in_folder("a b.mp4")), 7);
        free(texels);
    }
}

static void a_film_without_frames_leaves_nothing(void **state)
{
    (void)state;
    app_film film;
    message_count = 0;
    assert_int_equal(app_film_open(&film, in_folder("none.mp4"), 16, 16, 24), KD_OK);
    assert_int_equal(app_film_close(&film), KD_OK);
    assert_int_equal(access(in_folder("none.mp4"), F_OK), -1);
    assert_int_equal(access(film.temp, F_OK), -1);
    assert_int_equal(message_count, 0);
}

static void a_film_whose_encoder_dies_is_one_message(void **state)
{
    (void)state;
    app_film film;
    uint8_t *texels = make_texels(640, 360);
    kd_status status = KD_OK;
    message_count = 0;
    /* ffmpeg cannot open a file in a folder that is not there, and ends; writing to it then fails. */
    assert_int_equal(app_film_open(&film, in_folder("missing/a.mp4"), 640, 360, 24), KD_OK);
    for (int frame = 0; frame < 200 && status == KD_OK; frame++)
        status = app_film_write(&film, texels);
    if (status == KD_OK)
        status = app_film_close(&film);
    assert_int_equal(status, KD_IO);
    assert_int_equal(message_count, 1);
    assert_non_null(strstr(last_message, "missing/a.mp4: ffmpeg failed"));
    assert_int_equal(app_film_close(&film), KD_OK);
    free(texels);
}

static void outputs_are_checked_before_the_work(void **state)
{
    (void)state;
    char path[256];
    app_output output = {.path = path, .kind = APP_OUTPUT_PNG};
    app_options options = {.output_count = 1, .outputs = &output};
    snprintf(path, sizeof path, "%s/ok_%%04d.png", folder);
    output.every_frame = true;
    assert_int_equal(app_capture_check(&options), KD_OK);
    assert_int_equal(access(in_folder("ok_0000.png"), F_OK), -1); /* asking leaves nothing behind */
    message_count = 0;
    snprintf(path, sizeof path, "%s/missing/x.png", folder);
    output.every_frame = false;
    assert_int_not_equal(app_capture_check(&options), KD_OK);
    assert_int_equal(message_count, 1);
    char *kept = strdup(getenv("PATH"));
    snprintf(path, sizeof path, "%s/x.mp4", folder);
    output.kind = APP_OUTPUT_FILM;
    setenv("PATH", folder, 1);
    assert_int_equal(app_capture_check(&options), KD_NOT_FOUND);
    assert_non_null(strstr(last_message, "ffmpeg was not found"));
    setenv("PATH", kept, 1);
    free(kept);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_holds_the_pixels),
        cmocka_unit_test(a_failed_picture_leaves_nothing),
        cmocka_unit_test(a_picture_without_space_says_so),
        cmocka_unit_test(exr_is_half_floats_in_three_channels),
        cmocka_unit_test(only_whole_pictures_are_finished),
        cmocka_unit_test(films_have_every_frame),
        cmocka_unit_test(a_film_without_frames_leaves_nothing),
        cmocka_unit_test(a_film_whose_encoder_dies_is_one_message),
        cmocka_unit_test(outputs_are_checked_before_the_work),
    };
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
