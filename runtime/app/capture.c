#include "runtime/app/capture.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/film.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "runtime/app/child.h"
#include "runtime/app/film.h"
#include "runtime/app/image_write.h"
#include "runtime/app/picture.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "shaders/shared/film.h"

#define RING_DEPTH 3

/* What a file is made from. */
typedef enum source {
    FROM_LDR,         /* sRGB bytes */
    FROM_DEEP,        /* sRGB in 16 bits */
    FROM_HDR,         /* linear halfs, as rendered */
    FROM_MEAN,        /* linear floats, of a frame that is a mean */
    FROM_LAYERS,      /* slices of halfs */
    FROM_DEEP_LAYERS, /* slices of floats */
    SOURCE_COUNT
} source;

static const size_t texel_bytes[SOURCE_COUNT] = {4, 8, 8, 16, 8 * KD_LAYER_COUNT, 16 * KD_LAYER_COUNT};

/* A picture being encoded by a worker. */
typedef struct slot {
    kd_job_counter counter;
    app_capture *capture;
    void *texels;
    char path[KD_PATH_MAX];
    source from;
} slot;

struct app_capture {
    const app_options *options;
    kd_world *world;
    kd_gpu *gpu;
    kd_jobs *jobs;
    uint32_t width, height;
    kd_gpu_readback rings[SOURCE_COUNT]; /* id 0 when no output wants every frame of it */
    size_t largest;                      /* bytes of a picture, of those that are wanted */
    app_film *films;                     /* [option output], unused entries zero */
    slot *slots;
    uint32_t slot_count, next_slot;
    bool rests;                 /* the frames under way are not written */
    kd_status status;           /* of the lane */
    _Atomic(int) encode_status; /* first failure of a worker */
};

static size_t picture_bytes(const app_capture *c, source from)
{
    return (size_t)c->width * c->height * texel_bytes[from];
}

static source source_of(const app_output *output, const kd_film *film)
{
    if (output->kind == APP_OUTPUT_PNG)
        return film->deep ? FROM_DEEP : FROM_LDR;
    if (output->kind == APP_OUTPUT_FILM)
        return FROM_LDR;
    if (film->layers)
        return film->sub_frames > 1 ? FROM_DEEP_LAYERS : FROM_LAYERS;
    return kd_film_on(film) ? FROM_MEAN : FROM_HDR;
}

static source output_source(const app_capture *c, const app_output *output)
{
    return source_of(output, kd_singleton(c->world, kd_film));
}

static kd_gpu_texture texture_of(const app_capture *c, source from)
{
    const kd_picture *picture = kd_singleton(c->world, kd_picture);
    switch (from) {
    case FROM_LDR: return picture->ldr;
    case FROM_DEEP: return picture->deep;
    case FROM_HDR: return picture->hdr;
    case FROM_MEAN: return picture->mean;
    default: return kd_singleton(c->world, kd_film_layers)->slices;
    }
}

static kd_status write_picture(const app_capture *c, const char *path, source from, const void *texels)
{
    switch (from) {
    case FROM_LDR: return app_png_write(path, c->width, c->height, texels);
    case FROM_DEEP: return app_png_write_deep(path, c->width, c->height, texels);
    case FROM_HDR: return app_exr_write(path, c->width, c->height, texels);
    case FROM_MEAN: return app_exr_write_floats(path, c->width, c->height, texels);
    default: return app_exr_write_layers(path, c->width, c->height, texels, from == FROM_DEEP_LAYERS);
    }
}

/* ---- before the work ---- */

/* The longest name that a pattern gives, or the path itself. */
static kd_status numbered_path(const app_output *output, uint64_t frame, char out[KD_PATH_MAX])
{
    const char *percent = strchr(output->path, '%');
    if (output->kind == APP_OUTPUT_FILM || !percent) {
        snprintf(out, KD_PATH_MAX, "%s", output->path);
        return KD_OK;
    }
    const char *p = percent + 1;
    int zero = *p == '0', digits = 0;
    p += zero;
    if (*p >= '0' && *p <= '9')
        digits = *p++ - '0';
    int written =
        snprintf(out, KD_PATH_MAX, zero ? "%.*s%0*llu%s" : "%.*s%*llu%s", (int)(percent - output->path),
                 output->path, digits, (unsigned long long)frame, p + 1);
    return written < KD_PATH_MAX
               ? KD_OK
               : kd_fail(KD_OUT_OF_RANGE, "%.64s…: the path is too long; shorten it", output->path);
}

kd_status app_capture_check(const app_options *options)
{
    char path[KD_PATH_MAX];
    for (uint32_t i = 0; i < options->output_count; i++) {
        kd_file_out probe;
        kd_status status = numbered_path(&options->outputs[i], 0, path);
        if (status == KD_OK)
            status = kd_file_out_open(&probe, path);
        if (status != KD_OK)
            return status;
        bool plain = probe.temp[0] != '\0';
        kd_file_out_cancel(&probe);
        if (options->outputs[i].kind == APP_OUTPUT_FILM && !plain)
            return kd_fail(KD_UNSUPPORTED,
                           "%s: is a pipe or device, which cannot hold a film; name a plain file",
                           options->outputs[i].path);
        if (options->outputs[i].kind == APP_OUTPUT_FILM && !app_find_program("ffmpeg", path, sizeof path))
            return kd_fail(KD_NOT_FOUND,
                           "%s: ffmpeg was not found in PATH; install it, or write %%04d.png files",
                           options->outputs[i].path);
    }
    return KD_OK;
}

static kd_status open_rings(app_capture *c)
{
    for (uint32_t i = 0; i < c->options->output_count; i++) {
        source from = output_source(c, &c->options->outputs[i]);
        size_t bytes = picture_bytes(c, from);
        if (!c->options->outputs[i].every_frame || c->rings[from].id)
            continue;
        c->rings[from] = kd_gpu_make_readback(c->gpu, bytes, RING_DEPTH, "capture");
        if (!c->rings[from].id)
            return KD_GPU;
        c->largest = bytes > c->largest ? bytes : c->largest;
    }
    return KD_OK;
}

static kd_status open_films(app_capture *c, double fps)
{
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < c->options->output_count && status == KD_OK; i++)
        if (c->options->outputs[i].kind == APP_OUTPUT_FILM)
            status = app_film_open(&c->films[i], c->options->outputs[i].path, c->width, c->height, fps);
    return status;
}

kd_status app_capture_open(const app_options *options, kd_world *w, kd_gpu *gpu, kd_jobs *jobs,
                           uint32_t width, uint32_t height, double fps, app_capture **out)
{
    app_capture *c = calloc(1, sizeof *c);
    *out = c;
    if (!c)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    *c = (app_capture){
        .options = options, .world = w, .gpu = gpu, .jobs = jobs, .width = width, .height = height};
    c->slot_count = kd_jobs_threads(jobs) + 1;
    c->films = calloc(options->output_count + 1, sizeof *c->films);
    c->slots = calloc(c->slot_count, sizeof *c->slots);
    if (!c->films || !c->slots)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = open_rings(c);
    return status == KD_OK ? open_films(c, fps) : status;
}

/* ---- one frame's texels to files ---- */

static void note(app_capture *c, kd_status status)
{
    if (c->status == KD_OK)
        c->status = status;
}

static void encode(void *user, uint32_t worker)
{
    (void)worker;
    slot *s = user;
    app_capture *c = s->capture;
    kd_status status = write_picture(c, s->path, s->from, s->texels);
    int none = KD_OK;
    if (status != KD_OK)
        atomic_compare_exchange_strong(&c->encode_status, &none, (int)status);
}

/* Hand a copy of the texels to a worker; waits when all slots are busy. */
static kd_status queue_picture(app_capture *c, const app_output *output, const void *texels, uint64_t frame,
                               source from)
{
    slot *s = &c->slots[c->next_slot++ % c->slot_count];
    kd_jobs_wait(c->jobs, &s->counter);
    if (!s->texels)
        s->texels = malloc(c->largest);
    if (!s->texels)
        return kd_fail(KD_NO_MEMORY, "%s: no memory for a picture of %ux%u; choose a smaller size",
                       output->path, c->width, c->height);
    memcpy(s->texels, texels, picture_bytes(c, from));
    s->capture = c;
    s->from = from;
    kd_status status = numbered_path(output, frame, s->path);
    if (status == KD_OK)
        kd_jobs_run(c->jobs, encode, s, &s->counter);
    return status;
}

static void store_frame(app_capture *c, const void *texels, uint64_t frame, source from)
{
    for (uint32_t i = 0; i < c->options->output_count && app_capture_status(c) == KD_OK; i++) {
        const app_output *output = &c->options->outputs[i];
        if (!output->every_frame || output_source(c, output) != from)
            continue;
        if (output->kind == APP_OUTPUT_FILM)
            note(c, app_film_write(&c->films[i], texels));
        else
            note(c, queue_picture(c, output, texels, frame, from));
    }
}

/* Take what has come back; with `wait`, one at least. Returns false when nothing was under way. */
static bool take(app_capture *c, source from, bool wait)
{
    uint64_t frame;
    size_t size;
    const void *texels = kd_gpu_readback_poll(c->gpu, c->rings[from], wait, &frame, &size);
    if (texels)
        store_frame(c, texels, frame, from);
    return texels != NULL;
}

static void queue_copy(app_capture *c, source from, uint64_t frame)
{
    kd_status status;
    kd_gpu_texture texture = texture_of(c, from);
    while (take(c, from, false))
        ;
    /* All areas in flight: the disk or the encoder is slower than the picture, so wait for the oldest. */
    while ((status = kd_gpu_readback_texture(c->gpu, c->rings[from], texture, 0, frame)) == KD_OUT_OF_RANGE)
        if (!take(c, from, true))
            break;
    note(c, status);
}

static bool is_due(kd_system_context *context)
{
    const app_capture *c = context->user;
    return !c->rests && kd_film_is_last(kd_singleton(context->world, kd_film));
}

static void run(kd_system_context *context)
{
    app_capture *c = context->user;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    for (int from = 0; from < SOURCE_COUNT; from++)
        if (c->rings[from].id && app_capture_status(c) == KD_OK)
            queue_copy(c, (source)from, frame->index);
}

kd_status app_capture_import(app_capture *capture, kd_schedule *s)
{
    return kd_schedule_add(
        s,
        &(kd_system_desc){
            .name = "capture",
            .phase = KD_PHASE_CAPTURE,
            .where = KD_ON_GPU,
            .components = {KD_USES(kd_picture), KD_USES(kd_frame), KD_USES(kd_film), KD_USES(kd_film_layers)},
            .resources = {{"picture", KD_USE_COPY_READ}, {"film.layers", KD_USE_COPY_READ}},
            .no_commands = true,
            .run_if = is_due,
            .run = run,
            .user = capture,
        });
}

/* ---- frames that are there already ---- */

bool app_capture_wants(const app_capture *c, uint64_t frame, bool last)
{
    char path[KD_PATH_MAX];
    for (uint32_t i = 0; i < c->options->output_count; i++) {
        const app_output *output = &c->options->outputs[i];
        if (output->kind == APP_OUTPUT_FILM || (!output->every_frame && last))
            return true;
        if (output->every_frame &&
            (numbered_path(output, frame, path) != KD_OK || !app_picture_is_whole(path)))
            return true;
    }
    return false;
}

void app_capture_rest(app_capture *c, bool rests)
{
    c->rests = rests;
}

/* ---- the end ---- */

kd_status app_capture_status(const app_capture *capture)
{
    if (capture->status != KD_OK)
        return capture->status;
    return (kd_status)atomic_load(&capture->encode_status);
}

/* Read what the outputs of the last frame alone are made from, and write them. */
static kd_status write_last(app_capture *c, source from)
{
    kd_status status = KD_OK;
    void *texels = NULL;
    for (uint32_t i = 0; i < c->options->output_count && status == KD_OK; i++) {
        const app_output *output = &c->options->outputs[i];
        if (output->every_frame || output_source(c, output) != from)
            continue;
        if (!texels && !(texels = malloc(picture_bytes(c, from)))) {
            status = kd_fail(KD_NO_MEMORY, "%s: no memory for a picture of %ux%u; choose a smaller size",
                             output->path, c->width, c->height);
            break;
        }
        kd_gpu_barrier(c->gpu, KD_BARRIER_TEXTURE_UPDATE);
        kd_gpu_read_texture(c->gpu, texture_of(c, from), 0, texels, picture_bytes(c, from));
        status = kd_gpu_failed(c->gpu) ? KD_GPU : write_picture(c, output->path, from, texels);
    }
    free(texels);
    return status;
}

kd_status app_capture_finish(app_capture *c, bool last)
{
    if (!c)
        return KD_OK;
    for (int from = 0; from < SOURCE_COUNT; from++)
        while (c->rings[from].id && take(c, (source)from, true))
            ;
    for (uint32_t i = 0; i < c->slot_count; i++)
        kd_jobs_wait(c->jobs, &c->slots[i].counter);
    kd_status status = app_capture_status(c);
    for (uint32_t i = 0; i < c->options->output_count; i++) {
        kd_status closed =
            c->options->outputs[i].kind == APP_OUTPUT_FILM ? app_film_close(&c->films[i]) : KD_OK;
        status = status == KD_OK ? closed : status;
    }
    for (int from = 0; from < SOURCE_COUNT && last; from++)
        status = status == KD_OK ? write_last(c, (source)from) : status;
    return status;
}

void app_capture_close(app_capture *c)
{
    if (!c)
        return;
    for (uint32_t i = 0; c->slots && i < c->slot_count; i++) {
        kd_jobs_wait(c->jobs, &c->slots[i].counter);
        free(c->slots[i].texels);
    }
    for (uint32_t i = 0; c->films && i < c->options->output_count; i++) {
        if (c->films[i].child.pid > 0)
            c->films[i].frames = 0; /* an unfinished film is no film */
        app_film_close(&c->films[i]);
    }
    for (int from = 0; from < SOURCE_COUNT; from++)
        if (c->rings[from].id)
            kd_gpu_destroy_readback(c->gpu, c->rings[from]);
    free(c->films);
    free(c->slots);
    free(c);
}
