/* `kandil compare BEFORE NOW --temporal`: what flickers between two frames. The earlier picture is brought to
 * where its surfaces are in the later one, and both are compared where they can be seen in both. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/app/comparison.h"
#include "runtime/asset/exr_shim.h"
#include "runtime/compare/compare.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

enum {
    FINAL,
    DIRECT,
    INDIRECT,
    TERM_COUNT,
    DEPTH = TERM_COUNT * 3,
    NORMAL,
    MOTION = NORMAL + 3,
    CHANNEL_COUNT = MOTION + 2
};

static const char *const term_names[TERM_COUNT] = {"final", "direct", "indirect"};
static const char *const channel_names[CHANNEL_COUNT] = {
    "R",          "G", "B",   "direct.R", "direct.G", "direct.B", "indirect.R", "indirect.G",
    "indirect.B", "Z", "N.X", "N.Y",      "N.Z",      "motion.X", "motion.Y"};

/* A frame as its file has it. */
typedef struct frame {
    uint32_t width, height;
    size_t texels;
    float *planes; /* CHANNEL_COUNT of them */
    kd_surfaces surfaces;
} frame;

static const float *plane(const frame *f, size_t channel)
{
    return f->planes + channel * f->texels;
}

static kd_status check_finite(const char *path, const frame *f)
{
    for (size_t i = 0; i < f->texels * CHANNEL_COUNT; i++)
        if (!isfinite(f->planes[i]))
            return kd_fail(KD_BAD_FORMAT, "%s: a value of channel %s is not finite; correct the picture",
                           path, channel_names[i / f->texels]);
    return KD_OK;
}

static kd_status read_frame(const char *path, frame *f)
{
    void *data;
    size_t size;
    const char *error, *missing;
    kd_status status = kd_file_read(path, (size_t)1 << 31, &data, &size);
    if (status != KD_OK)
        return status;
    f->planes =
        exr_shim_planes(data, size, channel_names, CHANNEL_COUNT, &f->width, &f->height, &error, &missing);
    free(data);
    if (!f->planes && missing)
        return kd_fail(KD_BAD_FORMAT, "%s: has no channel %s; write it with `kandil run --layers`", path,
                       missing);
    if (!f->planes)
        return kd_fail(KD_BAD_FORMAT, "%s: %s; give an .exr that `kandil run --layers` wrote", path, error);
    f->texels = (size_t)f->width * f->height;
    f->surfaces = (kd_surfaces){plane(f, DEPTH),
                                {plane(f, NORMAL), plane(f, NORMAL + 1), plane(f, NORMAL + 2)},
                                {plane(f, MOTION), plane(f, MOTION + 1)}};
    return check_finite(path, f);
}

static kd_status picture_of(const frame *f, size_t term, app_picture *out)
{
    kd_status status = app_picture_make(out, f->width, f->height);
    for (size_t i = 0; status == KD_OK && i < f->texels; i++)
        for (size_t c = 0; c < 3; c++)
            out->rgb[i * 3 + c] = plane(f, term * 3 + c)[i];
    return status;
}

/* Pixels that were hidden are equal in both and do not count; they are black in the map. */
static kd_status measure_term(const frame frames[2], size_t term, float exposure, kd_tonemap curve,
                              uint8_t *seen, app_pair *pair)
{
    const frame *now = &frames[1];
    app_picture before = {0};
    kd_status status = picture_of(&frames[0], term, &before);
    if (status == KD_OK)
        status = picture_of(now, term, &pair->test);
    if (status == KD_OK)
        status = app_picture_make(&pair->reference, now->width, now->height);
    if (status == KD_OK)
        kd_reproject(&frames[0].surfaces, before.rgb, &now->surfaces, pair->test.rgb, now->width, now->height,
                     pair->reference.rgb, seen);
    if (status == KD_OK)
        status = app_pair_measure(pair, exposure, curve, false);
    if (status == KD_OK)
        pair->difference.flip = kd_mean_seen(pair->map, seen, now->texels);
    pair->difference.ssim = NAN;
    snprintf(pair->name, sizeof pair->name, "%s", term_names[term]);
    pair->tracer_s = NAN;
    app_picture_fini(&before);
    return status;
}

static double share_of(const uint8_t *seen, size_t count)
{
    size_t sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += seen[i];
    return (double)sum / (double)count;
}

static kd_status measure(const app_options *o, const kd_settings *settings, const frame frames[2])
{
    app_pair pairs[TERM_COUNT] = {0};
    app_picture now = {0};
    uint8_t *seen = malloc(frames[1].texels);
    kd_status status = seen ? picture_of(&frames[1], FINAL, &now)
                            : kd_fail(KD_NO_MEMORY, "no memory for pictures of %ux%u; choose a smaller size",
                                      frames[1].width, frames[1].height);
    float exposure = status == KD_OK ? app_picture_exposure(&now, settings) : 1;
    for (size_t i = 0; i < TERM_COUNT && status == KD_OK; i++)
        status = measure_term(frames, i, exposure, (kd_tonemap)settings->view_tonemap, seen, &pairs[i]);
    if (status == KD_OK) {
        char words[128];
        snprintf(words, sizeof words, "%.80s moved, %.1f %% of which is seen again", o->subject,
                 100 * share_of(seen, frames[1].texels));
        status = app_comparison_report(o, o->second, words, pairs, TERM_COUNT);
    }
    for (size_t i = 0; i < TERM_COUNT; i++)
        app_pair_fini(&pairs[i]);
    app_picture_fini(&now);
    free(seen);
    return status;
}

kd_status app_compare_temporal(const app_options *o, const kd_settings *settings)
{
    frame frames[2] = {0};
    kd_status status = read_frame(o->subject, &frames[0]);
    if (status == KD_OK)
        status = read_frame(o->second, &frames[1]);
    if (status == KD_OK && (frames[0].width != frames[1].width || frames[0].height != frames[1].height))
        status = kd_fail(KD_BAD_FORMAT, "%s: has %ux%u pixels, but %s has %ux%u; give pictures of one size",
                         o->subject, frames[0].width, frames[0].height, o->second, frames[1].width,
                         frames[1].height);
    if (status == KD_OK)
        status = measure(o, settings, frames);
    free(frames[0].planes);
    free(frames[1].planes);
    return status;
}
