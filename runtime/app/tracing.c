/* `kandil reference`: the world's CPU systems bring it to a frame, the path tracer does the rest. No GPU is
 * asked. */
#include "runtime/app/tracing.h"

#include <stdio.h>
#include <string.h>

#include "runtime/app/app.h"
#include "runtime/app/console.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/picture.h"
#include "runtime/app/world_setup.h"
#include "runtime/core/file.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"

/* ---- outputs ---- */

/* The path of a term: the one given for the final picture or for the only term, else with the term's name
 * behind it. */
static kd_status term_path(const app_options *o, const char *given, int term, char out[KD_PATH_MAX])
{
    uint32_t terms = o->tracing.terms;
    bool own = term != KD_REFERENCE_FINAL && (terms & (terms - 1)) != 0;
    const char *extension = kd_path_extension(given);
    int length = snprintf(out, KD_PATH_MAX, "%.*s%s%s%s", (int)(extension - given), given, own ? "_" : "",
                          own ? app_term_words[term] : "", extension);
    return length < KD_PATH_MAX
               ? KD_OK
               : kd_fail(KD_USAGE, "--out: %s: the path is too long; use a shorter one", given);
}

static bool wants_term(const app_options *o, int term)
{
    return o->tracing.terms ? o->tracing.terms >> term & 1 : term == KD_REFERENCE_FINAL;
}

static kd_status check_outputs(const app_options *o)
{
    kd_status status = KD_OK;
    kd_file_out probe;
    if (!o->output_count)
        return kd_fail(KD_USAGE, "reference needs a file to write; add --out picture.exr");
    for (uint32_t i = 0; i < o->output_count && status == KD_OK; i++) {
        const app_output *output = &o->outputs[i];
        if (output->every_frame)
            return kd_fail(KD_USAGE, "--out: %s: one frame is traced; name a .exr or .png without a number",
                           output->path);
        status = kd_file_out_open(&probe, output->path);
        if (status == KD_OK)
            kd_file_out_cancel(&probe);
    }
    return status;
}

/* The values of a term as its PNG shows them: light by exposure and curve, the rest as `--view` does. */
static void encode_data(app_picture *p, int term)
{
    size_t count = (size_t)p->width * p->height * 3;
    for (size_t i = 0; i < count && term == KD_REFERENCE_DEPTH; i++)
        p->rgb[i] = p->rgb[i] > 0 ? 1 / (1 + p->rgb[i]) : 0;
    p->encoded = term == KD_REFERENCE_NORMAL || term == KD_REFERENCE_DEPTH;
}

static kd_status write_term(const app_traced *t, const app_output *output, int term, float exposure)
{
    char path[KD_PATH_MAX];
    app_picture p;
    kd_tonemap curve = (kd_tonemap)t->scene.settings.view_tonemap;
    kd_status status = app_picture_make(&p, t->scene.width, t->scene.height);
    if (status == KD_OK)
        status = term_path(t->options, output->path, term, path);
    if (status == KD_OK) {
        kd_reference_read(t->reference, (kd_reference_term)term, p.rgb);
        if (output->kind == APP_OUTPUT_EXR) {
            status = app_picture_write_exr(path, &p);
        } else {
            bool light = term <= KD_REFERENCE_SPECULAR;
            encode_data(&p, term);
            status = app_picture_write_png(path, &p, light ? exposure : 1, light ? curve : KD_TONEMAP_LINEAR);
        }
    }
    app_picture_fini(&p);
    return status;
}

/* One exposure for all terms: the final picture's. */
static kd_status write_pictures(const app_traced *t)
{
    app_picture final;
    kd_status status = app_picture_make(&final, t->scene.width, t->scene.height);
    if (status != KD_OK)
        return status;
    kd_reference_read(t->reference, KD_REFERENCE_FINAL, final.rgb);
    float exposure = app_picture_exposure(&final, &t->scene.settings);
    app_picture_fini(&final);
    for (uint32_t i = 0; i < t->options->output_count; i++)
        for (int term = 0; term < KD_REFERENCE_TERM_COUNT && status == KD_OK; term++)
            if (wants_term(t->options, term))
                status = write_term(t, &t->options->outputs[i], term, exposure);
    return status;
}

/* ---- figures ---- */

static void put_uint(kd_json *j, const char *key, uint64_t value)
{
    kd_json_key(j, key);
    kd_json_uint(j, value);
}

static void put_double(kd_json *j, const char *key, double value)
{
    kd_json_key(j, key);
    kd_json_double(j, value);
}

static kd_status write_stats(const app_traced *t, const kd_reference_info *info)
{
    kd_json j = {.indent = 2};
    kd_json_object_begin(&j);
    kd_json_key(&j, "kandil");
    kd_json_string(&j, KD_VERSION);
    kd_json_key(&j, "size");
    kd_json_array_begin(&j);
    kd_json_uint(&j, info->width);
    kd_json_uint(&j, info->height);
    kd_json_array_end(&j);
    put_uint(&j, "frame", app_tracing_frame(&t->scene, t->options));
    put_uint(&j, "spp", info->spp);
    put_uint(&j, "rays", info->rays);
    put_uint(&j, "triangles", info->triangles);
    put_uint(&j, "emitters", info->emitters);
    put_uint(&j, "lights", info->lights);
    put_uint(&j, "bad_samples", info->bad_samples);
    put_double(&j, "build_s", info->build_s);
    put_double(&j, "trace_s", info->trace_s);
    put_double(&j, "noise_relmse", info->noise);
    kd_json_object_end(&j);
    const char *text = kd_json_text(&j);
    kd_status status = text ? kd_file_write(t->options->stats, text, strlen(text))
                            : kd_fail(KD_NO_MEMORY, "%s: out of memory", t->options->stats);
    kd_json_fini(&j);
    return status;
}

static void print_summary(const kd_reference_info *info)
{
    kd_log(KD_LOG_INFO,
           "%u samples a pixel in %.1f s, %.2f million rays a second, relative squared error about %.2g",
           info->spp, info->trace_s, info->trace_s > 0 ? (double)info->rays / info->trace_s * 1e-6 : 0,
           info->noise);
    if (info->bad_samples)
        kd_log(KD_LOG_WARNING, "reference: %llu samples were not finite and count as black",
               (unsigned long long)info->bad_samples);
}

/* ---- tracing ---- */

static bool show_progress(void *user, uint32_t done, uint32_t spp, double pass_ms)
{
    (void)user;
    app_console_progress(done, spp, pass_ms);
    return !app_interrupted();
}

/* A comparison is fair when both sides count the same light: the setting's, unless the command line says
 * otherwise. */
static app_tracing asked_for(const app_traced *t)
{
    app_tracing asked = t->options->tracing;
    if (t->options->command == APP_COMPARE && !asked.bounces_said) {
        int32_t bounces = t->scene.settings.light_bounces;
        asked.bounces = bounces == KD_BOUNCES_INF ? KD_REFERENCE_ENDLESS : bounces;
        asked.gathered = true;
    }
    return asked;
}

static kd_status trace_world(app_traced *t)
{
    const app_tracing *a = &t->asked;
    kd_status status = kd_reference_open(t->world, t->jobs,
                                         &(kd_reference_desc){
                                             .spp = a->spp,
                                             .bounces = a->bounces,
                                             .gathered = a->gathered,
                                             .seed = t->options->seed,
                                             .lambert = a->lambert,
                                             .centre = a->centre,
                                             .ambient_occlusion = (a->terms >> KD_REFERENCE_AO & 1) != 0,
                                             .time_budget_s = a->time_budget_s,
                                             .noise = a->noise,
                                             .progress = show_progress,
                                         },
                                         &t->reference);
    if (status == KD_OK)
        status = kd_reference_render(t->reference);
    app_console_clear();
    return status;
}

uint64_t app_tracing_frame(const app_scene *scene, const app_options *o)
{
    uint64_t frames = app_scene_frames(scene, o);
    return o->tracing.frame >= 0 ? (uint64_t)o->tracing.frame : frames > 0 ? frames - 1 : 0;
}

/* Every step up to the frame is taken: what a scenario does may depend on all before. */
static kd_status step_to_frame(app_traced *t)
{
    uint64_t last = app_tracing_frame(&t->scene, t->options);
    kd_status status = KD_OK;
    for (uint64_t i = 0; i <= last && status == KD_OK; i++) {
        if (app_interrupted())
            return KD_INTERRUPTED;
        status = app_scene_step(&t->scene, i);
        if (status == KD_OK)
            status = kd_schedule_run(t->schedule);
    }
    return status;
}

static kd_status open_world(app_traced *t)
{
    kd_status status;
    t->jobs = kd_jobs_make(t->options->threads);
    t->world = kd_world_make();
    if (!t->jobs || !t->world)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    status = app_scene_load(&t->scene, t->world, t->options, NULL);
    if (status != KD_OK)
        return status;
    t->schedule = kd_schedule_make(t->world, t->jobs, NULL);
    if (!t->schedule)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    status = app_import_state_systems(t->schedule, t->options->extension);
    return status == KD_OK ? kd_schedule_init(t->schedule) : status;
}

kd_status app_traced_open(app_traced *t, const app_options *options)
{
    *t = (app_traced){.options = options};
    kd_status status = open_world(t);
    t->asked = asked_for(t);
    if (status == KD_OK)
        status = step_to_frame(t);
    return status == KD_OK ? trace_world(t) : status;
}

void app_traced_close(app_traced *t)
{
    kd_reference_close(t->reference);
    if (t->schedule)
        kd_schedule_destroy(t->schedule);
    app_scene_fini(&t->scene);
    if (t->world)
        kd_world_destroy(t->world);
    if (t->jobs)
        kd_jobs_destroy(t->jobs);
    *t = (app_traced){0};
}

/* An interrupted picture is kept with the samples it has. */
static kd_status finish(app_traced *t, kd_status status)
{
    kd_reference_info info = kd_reference_get_info(t->reference);
    if ((status != KD_OK && status != KD_INTERRUPTED) || info.spp == 0)
        return status;
    kd_status written = write_pictures(t);
    if (written == KD_OK && t->options->stats)
        written = write_stats(t, &info);
    print_summary(&info);
    return written == KD_OK ? status : written;
}

kd_status app_reference_run(const app_options *options)
{
    app_traced t = {0};
    app_interrupt_install();
    kd_status status = check_outputs(options);
    if (status != KD_OK)
        return status;
    status = app_traced_open(&t, options);
    if (t.reference)
        status = finish(&t, status);
    app_traced_close(&t);
    return status;
}
