#include "runtime/app/film.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/log.h"
#include "runtime/core/temp_files.h"

#define PIXELS "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"
enum { MAX_ARGUMENTS = 64 };

static const char *const mp4_arguments[] = {"-c:v",     "libx264",   "-crf",       "18", "-preset",
                                            "veryfast", "-movflags", "+faststart", NULL};
static const char *const webm_arguments[] = {"-c:v",    "libvpx-vp9", "-crf", "24",        "-b:v",
                                             "0",       "-deadline",  "good", "-cpu-used", "5",
                                             "-row-mt", "1",          NULL};
static const char *const color_arguments[] = {"-colorspace",  "bt709",      "-color_primaries",
                                              "bt709",        "-color_trc", "iec61966-2-1",
                                              "-color_range", "tv",         NULL};

static void add_arguments(const char *argv[MAX_ARGUMENTS], const char *const *more)
{
    size_t count = 0;
    while (argv[count])
        count++;
    while (*more && count + 1 < MAX_ARGUMENTS)
        argv[count++] = *more++;
    argv[count] = NULL;
}

kd_status app_film_open(app_film *film, const char *path, uint32_t width, uint32_t height, double fps)
{
    char size[32], rate[32];
    memset(film, 0, sizeof *film);
    film->child.input = film->child.errors = -1;
    film->frame_bytes = (size_t)width * height * 4;
    snprintf(size, sizeof size, "%ux%u", width, height);
    snprintf(rate, sizeof rate, "%.9g", fps);
    int kept = snprintf(film->path, sizeof film->path, "%s", path);
    int written = snprintf(film->temp, sizeof film->temp, "%s.part%ld%s", path, (long)getpid(),
                           kd_path_extension(path));
    if (kept >= (int)sizeof film->path || written >= (int)sizeof film->temp)
        return kd_fail(KD_OUT_OF_RANGE, "%.64s…: the path is too long; shorten it", path);
    /* A leading "./" keeps ffmpeg from reading a name such as "-x.mp4" or "a:b.mp4" as something else. */
    char target[KD_PATH_MAX + 8];
    snprintf(target, sizeof target, "%s%s", film->temp[0] == '/' ? "file:" : "file:./", film->temp);
    /* Without -xerror it calls a film that did not fit on the disk a success. */
    const char *argv[MAX_ARGUMENTS] = {"ffmpeg",  "-hide_banner", "-loglevel", "error",    "-nostats",
                                       "-xerror", "-y",           "-f",        "rawvideo", "-pix_fmt",
                                       "rgba",    "-s",           size,        "-r",       rate,
                                       "-i",      "pipe:0",       "-vf",       PIXELS,     NULL};
    add_arguments(argv, kd_path_has_extension(path, ".webm") ? webm_arguments : mp4_arguments);
    add_arguments(argv, color_arguments);
    add_arguments(argv, (const char *const[]){target, NULL});
    kd_temp_files_add(film->temp);
    return app_child_start(&film->child, argv);
}

static void remove_temp(const app_film *film)
{
    unlink(film->temp);
    kd_temp_files_forget(film->temp);
}

/* Wait for the child and tell whether it did its work; when not, remove what it left and say why. */
static kd_status finish_child(app_film *film, bool write_failed)
{
    char line[256];
    int code = app_child_finish(&film->child, line, sizeof line);
    if (code == 0 && !write_failed)
        return KD_OK;
    remove_temp(film);
    return kd_fail(
        KD_IO,
        "%s: ffmpeg failed with code %d (%s); check the free space and that ffmpeg has libx264 and libvpx",
        film->path, code, line[0] ? line : "it said nothing");
}

kd_status app_film_write(app_film *film, const void *rgba)
{
    if (!app_child_write(&film->child, rgba, film->frame_bytes))
        return finish_child(film, true);
    film->frames++;
    return KD_OK;
}

kd_status app_film_close(app_film *film)
{
    if (film->child.pid == 0)
        return KD_OK;
    if (film->frames == 0) { /* which ffmpeg calls an error */
        app_child_finish(&film->child, NULL, 0);
        remove_temp(film);
        return KD_OK;
    }
    kd_status status = finish_child(film, false);
    if (status != KD_OK)
        return status;
    if (rename(film->temp, film->path) == 0) {
        kd_temp_files_forget(film->temp);
        return KD_OK;
    }
    int error = errno;
    remove_temp(film);
    return kd_fail(KD_IO, "%s: the film could not be put in place (%s); check the folder", film->path,
                   strerror(error));
}
