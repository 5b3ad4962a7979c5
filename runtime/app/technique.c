/* `kandil compare SCENE`: one frame by the path tracer and by each technique, term by term. */
#include "runtime/app/technique.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/render_targets.h"
#include "runtime/app/comparison.h"
#include "runtime/app/console.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/timing.h"
#include "runtime/app/tracing.h"
#include "runtime/app/world_setup.h"
#include "runtime/core/clock.h"
#include "runtime/core/file.h"
#include "runtime/core/half.h"
#include "runtime/core/log.h"

enum { TIMED_FRAMES = 5, TERM_COUNT = 6 };

/* What is compared. Diffuse is what indirect light is besides specular, which the renderer has no view of. */
static const struct {
    kd_reference_term term;
    kd_view_mode view;
    bool light;
} terms[TERM_COUNT] = {
    {KD_REFERENCE_FINAL, KD_VIEW_FINAL, true},
    {KD_REFERENCE_DIRECT, KD_VIEW_DIRECT, true},
    {KD_REFERENCE_INDIRECT, KD_VIEW_INDIRECT, true},
    {KD_REFERENCE_SPECULAR, KD_VIEW_SPECULAR, true},
    {KD_REFERENCE_AO, KD_VIEW_AO, false},
    {KD_REFERENCE_DIFFUSE, KD_VIEW_INDIRECT, true},
};
enum { INDIRECT = 2, SPECULAR = 3, DIFFUSE = 5 };

/* ---- one technique ---- */

typedef struct stage {
    const app_options *options;
    kd_jobs *jobs;
    kd_world *world;
    kd_gpu *gpu;
    kd_schedule *schedule;
    app_scene scene;
    app_timing timing;
} stage;

static kd_status stage_open(stage *s, const app_options *o)
{
    *s = (stage){.options = o, .jobs = kd_jobs_make(o->threads), .world = kd_world_make()};
    if (!s->jobs || !s->world)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = app_scene_load(&s->scene, s->world, o, NULL);
    if (status == KD_OK)
        status = kd_gpu_open(&(kd_gpu_desc){.api = o->context,
                                            .width = s->scene.width,
                                            .height = s->scene.height,
                                            .shaders = app_shaders(o->extension)},
                             &s->gpu);
    if (status != KD_OK)
        return status;
    s->schedule = kd_schedule_make(s->world, s->jobs, s->gpu);
    status =
        s->schedule ? app_import_systems(s->schedule, o->extension) : kd_fail(KD_NO_MEMORY, "out of memory");
    if (status == KD_OK)
        status = app_timing_open(
            &s->timing, &(app_timing_desc){.schedule = s->schedule, .gpu = s->gpu, .mode = APP_TIMING_OFF});
    return status == KD_OK ? kd_schedule_init(s->schedule) : status;
}

static void stage_close(stage *s)
{
    if (s->schedule)
        kd_schedule_destroy(s->schedule);
    app_timing_close(&s->timing);
    app_scene_fini(&s->scene);
    if (s->world)
        kd_world_destroy(s->world);
    if (s->gpu)
        kd_gpu_close(s->gpu);
    if (s->jobs)
        kd_jobs_destroy(s->jobs);
}

static kd_status run_frame(stage *s)
{
    app_timing_frame_begin(&s->timing);
    kd_status status = kd_schedule_run(s->schedule);
    if (status == KD_OK && kd_gpu_failed(s->gpu))
        status = KD_GPU;
    kd_gpu_end_frame(s->gpu);
    app_timing_frame_end(&s->timing);
    return status;
}

/* Step up to the frame and render it. It can then be rendered again with other views: its step takes no time,
 * so nothing moves. */
static kd_status render_up_to(stage *s, uint64_t last)
{
    kd_status status = KD_OK;
    for (uint64_t i = 0; i <= last && status == KD_OK; i++) {
        if (app_interrupted())
            return KD_INTERRUPTED;
        status = app_scene_step(&s->scene, i);
        if (i == last)
            kd_singleton(s->world, kd_frame)->dt_s = 0;
        if (status == KD_OK)
            status = run_frame(s);
        app_console_progress(i + 1, last + 1, 0);
    }
    app_console_clear();
    return status;
}

static kd_status read_picture(stage *s, app_picture *out)
{
    const kd_picture *picture = kd_singleton(s->world, kd_picture);
    size_t count = (size_t)picture->width * picture->height;
    uint16_t *half = malloc(count * 4 * sizeof *half);
    kd_status status = app_picture_make(out, picture->width, picture->height);
    if (!half && status == KD_OK)
        status = kd_fail(KD_NO_MEMORY, "no memory for a picture of %ux%u; choose a smaller size",
                         picture->width, picture->height);
    if (status == KD_OK) {
        kd_gpu_barrier(s->gpu, KD_BARRIER_TEXTURE_UPDATE);
        kd_gpu_read_texture(s->gpu, picture->hdr, 0, half, count * 4 * sizeof *half);
        status = kd_gpu_failed(s->gpu) ? KD_GPU : KD_OK;
    }
    for (size_t i = 0; status == KD_OK && i < count; i++)
        for (size_t k = 0; k < 3; k++)
            out->rgb[i * 3 + k] = kd_half_to_float(half[i * 4 + k]);
    free(half);
    return status;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median of some more renderings of the same frame. */
static kd_status time_frames(stage *s, double *frame_ms)
{
    double ms[TIMED_FRAMES];
    kd_status status = KD_OK;
    for (int i = 0; i < TIMED_FRAMES && status == KD_OK; i++) {
        uint64_t began = kd_clock_ns();
        status = run_frame(s);
        kd_gpu_finish(s->gpu);
        ms[i] = (double)(kd_clock_ns() - began) * 1e-6;
    }
    qsort(ms, TIMED_FRAMES, sizeof *ms, by_value);
    *frame_ms = ms[TIMED_FRAMES / 2];
    return status;
}

static kd_status render_terms(stage *s, app_pair *pairs, app_row *row)
{
    kd_frame *frame = kd_singleton(s->world, kd_frame);
    kd_status status = read_picture(s, &pairs[0].test);
    for (int t = 1; t < DIFFUSE && status == KD_OK; t++) {
        frame->view = (uint32_t)terms[t].view;
        status = run_frame(s);
        if (status == KD_OK)
            status = read_picture(s, &pairs[t].test);
    }
    if (status == KD_OK)
        status = app_picture_make(&pairs[DIFFUSE].test, frame->width, frame->height);
    for (size_t i = 0; status == KD_OK && i < (size_t)frame->width * frame->height * 3; i++)
        pairs[DIFFUSE].test.rgb[i] = fmaxf(pairs[INDIRECT].test.rgb[i] - pairs[SPECULAR].test.rgb[i], 0);
    frame->view = KD_VIEW_FINAL;
    if (status == KD_OK)
        status = time_frames(s, &row->frame_ms);
    row->gpu_bytes = kd_gpu_bytes(s->gpu);
    return status;
}

static kd_status render_technique(const app_options *given, uint32_t gi, app_pair *pairs, app_row *row)
{
    stage s;
    app_options o = *given;
    o.gi = (int)gi;
    o.view = KD_VIEW_FINAL;
    kd_status status = stage_open(&s, &o);
    if (status == KD_OK)
        status = render_up_to(&s, app_tracing_frame(&s.scene, &o));
    if (status == KD_OK)
        status = render_terms(&s, pairs, row);
    stage_close(&s);
    return status;
}

/* ---- the reference ---- */

static kd_status copy_reference(const app_traced *t, app_pair *pairs)
{
    kd_status status = KD_OK;
    for (int i = 0; i < TERM_COUNT && status == KD_OK; i++) {
        status = app_picture_make(&pairs[i].reference, t->scene.width, t->scene.height);
        if (status == KD_OK)
            kd_reference_read(t->reference, terms[i].term, pairs[i].reference.rgb);
    }
    return status;
}

static void describe(const app_traced *t, char *out, size_t size)
{
    char bounces[32] = "all";
    kd_reference_info info = kd_reference_get_info(t->reference);
    if (t->asked.bounces >= 0)
        snprintf(bounces, sizeof bounces, "%d", (int)t->asked.bounces);
    snprintf(out, size, "path tracing: frame %llu, %u samples a pixel, %s %s, noise about %.2g relMSE",
             (unsigned long long)app_tracing_frame(&t->scene, t->options), info.spp, bounces,
             t->asked.gathered ? "gathers" : "bounces", info.noise);
}

/* ---- all of them ---- */

/* Time that the path tracer takes to the error of a technique: its own falls as 1 / t. */
static void set_traced_time(app_pair *pair, double noise, double trace_s)
{
    pair->tracer_s =
        pair->difference.relative_mse > 0 ? noise * trace_s / pair->difference.relative_mse : NAN;
}

static kd_status render_row(const app_options *o, const app_traced *traced, app_comparison *c, uint32_t gi)
{
    const kd_settings *settings = &traced->scene.settings;
    app_row *row = &c->rows[c->row_count++];
    app_pair *pairs = &c->pairs[c->pair_count];
    *row = (app_row){.frame_ms = NAN, .gi_ms = NAN, .first_pair = c->pair_count, .pair_count = TERM_COUNT};
    c->pair_count += TERM_COUNT;
    snprintf(row->name, sizeof row->name, "%s", app_gi_words[gi]);
    kd_status status = copy_reference(traced, pairs);
    if (status == KD_OK)
        status = render_technique(o, gi, pairs, row);
    if (status != KD_OK)
        return status;
    float exposure = app_picture_exposure(&pairs[0].reference, settings);
    for (int i = 0; i < TERM_COUNT && status == KD_OK; i++) {
        snprintf(pairs[i].name, sizeof pairs[i].name, "%s %s", app_gi_words[gi],
                 app_term_words[terms[i].term]);
        status = app_pair_measure(&pairs[i], terms[i].light ? exposure : 1,
                                  terms[i].light ? (kd_tonemap)settings->view_tonemap : KD_TONEMAP_LINEAR,
                                  terms[i].light);
        pairs[i].tracer_s = NAN;
    }
    kd_reference_info info = kd_reference_get_info(traced->reference);
    set_traced_time(&pairs[0], info.noise, info.trace_s);
    set_traced_time(&pairs[INDIRECT], info.indirect_noise, info.trace_s);
    c->tracer_rate = info.indirect_noise * info.trace_s;
    return status;
}

static void set_gi_times(app_comparison *c)
{
    const app_row *none = NULL;
    for (uint32_t i = 0; i < c->row_count; i++)
        if (strcmp(c->rows[i].name, app_gi_words[KD_GI_NONE]) == 0)
            none = &c->rows[i];
    for (uint32_t i = 0; none && i < c->row_count; i++)
        c->rows[i].gi_ms = c->rows[i].frame_ms - none->frame_ms;
}

/* A path in the folder: words joined, with an extension. Errors OUT_OF_RANGE */
static kd_status report_path(char out[KD_PATH_MAX], const char *folder, const char *who, int term,
                             const char *rest)
{
    char name[96];
    snprintf(name, sizeof name, "%s_%s%s", who, app_term_words[terms[term].term], rest);
    return kd_path_join(out, KD_PATH_MAX, folder, name);
}

static kd_status write_both(const char *folder, const char *who, int term, const app_picture *linear,
                            const app_picture *shown)
{
    char path[KD_PATH_MAX];
    kd_status status = report_path(path, folder, who, term, ".exr");
    if (status == KD_OK)
        status = app_picture_write_exr(path, linear);
    if (status == KD_OK)
        status = report_path(path, folder, who, term, ".png");
    return status == KD_OK ? app_picture_write_png(path, shown, 1, KD_TONEMAP_LINEAR) : status;
}

static kd_status write_heat(const char *folder, const char *who, int term, const app_pair *pair)
{
    char path[KD_PATH_MAX];
    app_picture heat;
    kd_status status = app_pair_heat(pair, &heat);
    if (status == KD_OK)
        status = report_path(path, folder, who, term, "_flip.png");
    if (status == KD_OK)
        status = app_picture_write_png(path, &heat, 1, KD_TONEMAP_LINEAR);
    app_picture_fini(&heat);
    return status;
}

static kd_status write_pictures(const char *folder, const app_comparison *c)
{
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < c->pair_count && status == KD_OK; i++) {
        const app_pair *p = &c->pairs[i];
        const char *who = c->rows[i / TERM_COUNT].name;
        int term = (int)(i % TERM_COUNT);
        if (i < TERM_COUNT)
            status = write_both(folder, "reference", term, &p->reference, &p->shown[1]);
        if (status == KD_OK)
            status = write_both(folder, who, term, &p->test, &p->shown[0]);
        if (status == KD_OK)
            status = write_heat(folder, who, term, p);
    }
    return status;
}

static kd_status write_folder(const char *folder, const app_comparison *c)
{
    char path[KD_PATH_MAX];
    kd_status status = kd_folder_make(folder);
    if (status == KD_OK)
        status = kd_path_join(path, sizeof path, folder, "report.json");
    if (status == KD_OK)
        status = app_comparison_write_json(path, c);
    if (status == KD_OK)
        status = kd_path_join(path, sizeof path, folder, "report.html");
    if (status == KD_OK)
        status = app_comparison_write_html(path, c);
    return status == KD_OK ? write_pictures(folder, c) : status;
}

static kd_status report(const app_options *o, app_comparison *c)
{
    set_gi_times(c);
    app_comparison_print(c);
    kd_status status = o->json ? app_comparison_write_json(o->json, c) : KD_OK;
    if (status == KD_OK && o->html)
        status = app_comparison_write_html(o->html, c);
    return status == KD_OK && o->report ? write_folder(o->report, c) : status;
}

static kd_status compare(const app_options *o, const app_traced *traced, app_comparison *c)
{
    uint32_t techniques = o->techniques ? o->techniques : UINT32_MAX, count = 0;
    while (app_gi_words[count])
        count++;
    c->rows = calloc(count, sizeof *c->rows);
    c->pairs = calloc((size_t)count * TERM_COUNT, sizeof *c->pairs);
    if (!c->rows || !c->pairs)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    describe(traced, c->reference, sizeof c->reference);
    c->width = traced->scene.width;
    c->height = traced->scene.height;
    kd_status status = KD_OK;
    for (uint32_t gi = 0; gi < count && status == KD_OK; gi++)
        if (techniques >> gi & 1)
            status = render_row(o, traced, c, gi);
    return status == KD_OK ? report(o, c) : status;
}

kd_status app_compare_techniques(const app_options *given)
{
    app_options o = *given;
    app_traced traced = {0};
    app_comparison c = {.title = given->subject};
    app_interrupt_install();
    for (int i = 0; i < TERM_COUNT; i++)
        o.tracing.terms |= 1u << terms[i].term;
    kd_status status = app_traced_open(&traced, &o);
    if (status == KD_OK)
        status = compare(&o, &traced, &c);
    for (uint32_t i = 0; c.pairs && i < c.pair_count; i++)
        app_pair_fini(&c.pairs[i]);
    free(c.pairs);
    free(c.rows);
    app_traced_close(&traced);
    return status;
}
