#include "runtime/app/stage.h"

#include <stdlib.h>

#include "components/film.h"
#include "components/voxel_scene.h"
#include "runtime/app/voxelize.h"
#include "runtime/app/world_setup.h"
#include "runtime/core/log.h"

static kd_status load(app_stage *stage, const app_options *options, const app_stage *beside)
{
    kd_status status = options->voxels ? app_voxel_file_open(&stage->voxels, options->voxels) : KD_OK;
    if (status != KD_OK)
        return status;
    stage->world = kd_world_make();
    if (!stage->world)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    if (options->voxels)
        kd_singleton(stage->world, kd_voxel_scene)->given = &stage->voxels;
    return app_scene_load(&stage->scene, stage->world, options, beside ? &beside->scene : NULL);
}

kd_status app_stage_load(const app_options *options, kd_jobs *jobs, const app_stage *beside, app_stage **out)
{
    app_stage *stage = calloc(1, sizeof *stage);
    *out = NULL;
    if (!stage)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    stage->options = *options;
    stage->jobs = jobs;
    kd_status status = load(stage, &stage->options, beside);
    if (status == KD_OK)
        *out = stage;
    else
        app_stage_close(stage);
    return status;
}

static kd_status configure_schedule(app_stage *stage, const app_stage_desc *desc)
{
    const kd_settings *settings = &stage->scene.settings;
    kd_schedule_set_step(stage->schedule, 1 / stage->scene.fps);
    kd_schedule_randomize(stage->schedule, (uint64_t)settings->debug_shuffle);
    kd_status status = kd_schedule_check(stage->schedule, settings->debug_access);
    if (status == KD_OK && desc->timing != APP_TIMING_OFF)
        status = kd_schedule_measure(stage->schedule, true);
    return status;
}

/* G-buffer, light gathered and summed, depth: what a rendered pixel has. */
enum { MAX_RENDERED_SIDE = 16384, BYTES_A_PIXEL = 80 };

/* What the settings say of films counts for what is written, and as it was when the frames began. */
static kd_status open_film(app_stage *stage)
{
    const app_scene *scene = &stage->scene;
    const kd_settings *s = &scene->settings;
    uint32_t n = (uint32_t)s->film_supersample;
    if (scene->width * n > MAX_RENDERED_SIDE || scene->height * n > MAX_RENDERED_SIDE)
        return kd_fail(
            KD_USAGE, "--supersample: %ux%u pixels, %u x %u each, are more than %d along a side; choose less",
            scene->width, scene->height, n, n, MAX_RENDERED_SIDE);
    if (s->film_layers && scene->view >= KD_VIEW_CACHES)
        return kd_fail(KD_USAGE, "--layers: a view of voxels has no layers; leave out one of both");
    *kd_singleton(stage->world, kd_film) = (kd_film){.supersample = n,
                                                     .sub_frames = (uint32_t)s->film_subframes,
                                                     .layers = s->film_layers,
                                                     .deep = s->film_png_depth == 16};
    if (n > 1)
        kd_log(KD_LOG_INFO, "%ux%u pixels are rendered a frame, which takes about %.0f MB", scene->width * n,
               scene->height * n, (double)scene->width * scene->height * n * n * BYTES_A_PIXEL * 1e-6);
    return s->film_subframes > 1 ? app_exposure_make(stage->world, &stage->exposure) : KD_OK;
}

static kd_status open_capture(app_stage *stage)
{
    const app_scene *scene = &stage->scene;
    kd_status status = app_capture_open(&stage->options, stage->world, stage->gpu, stage->jobs, scene->width,
                                        scene->height, scene->fps, &stage->capture);
    return status == KD_OK ? app_capture_import(stage->capture, stage->schedule) : status;
}

kd_status app_stage_open(app_stage *stage, const app_stage_desc *desc)
{
    stage->gpu = desc->gpu;
    stage->schedule = kd_schedule_make(stage->world, stage->jobs, stage->gpu);
    if (!stage->schedule)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = desc->captures && !stage->options.window ? open_film(stage) : KD_OK;
    if (status == KD_OK)
        status = app_import_systems(stage->schedule, stage->options.extension);
    if (status == KD_OK && desc->captures)
        status = open_capture(stage);
    if (status == KD_OK)
        status = app_timing_open(&stage->timing, &(app_timing_desc){.schedule = stage->schedule,
                                                                    .gpu = stage->gpu,
                                                                    .world = stage->world,
                                                                    .jobs = stage->jobs,
                                                                    .mode = desc->timing,
                                                                    .trace = desc->trace});
    if (status == KD_OK)
        status = kd_schedule_init(stage->schedule);
    return status == KD_OK ? configure_schedule(stage, desc) : status;
}

kd_status app_stage_renew(app_stage *stage)
{
    uint32_t width = stage->scene.width, height = stage->scene.height;
    kd_status status = app_scene_renew(&stage->scene, &stage->options);
    stage->scene.width = width;
    stage->scene.height = height;
    kd_schedule_set_step(stage->schedule, 1 / stage->scene.fps);
    return status;
}

/* ---- frames ---- */

static kd_status run_systems(app_stage *stage)
{
    kd_status status = kd_schedule_run(stage->schedule);
    app_timing_section(&stage->timing, APP_ROW_END, true);
    if (status == KD_OK && kd_gpu_failed(stage->gpu))
        status = KD_GPU;
    if (status == KD_OK && stage->capture)
        status = app_capture_status(stage->capture);
    kd_gpu_end_frame(stage->gpu);
    app_timing_frame_end(&stage->timing);
    return status;
}

static kd_status step(app_stage *stage, uint64_t index)
{
    app_timing_section(&stage->timing, APP_ROW_SCENARIO, true);
    kd_status status = app_scene_step(&stage->scene, index);
    app_timing_section(&stage->timing, APP_ROW_SCENARIO, false);
    return status;
}

/* ---- a frame as the mean of several moments ---- */

/* Systems that bring the world on, rather than show it. */
static bool brings_on(const kd_system_desc *system)
{
    return system->where == KD_ON_CPU && system->phase <= KD_PHASE_ANIMATE;
}

static bool is_on_gpu(const kd_system_desc *system)
{
    return system->where == KD_ON_GPU;
}

static void enable(app_stage *stage, bool (*chosen)(const kd_system_desc *system), bool enabled)
{
    for (uint32_t i = 0; i < kd_schedule_count(stage->schedule); i++) {
        const kd_system_desc *system = kd_schedule_system(stage->schedule, i);
        if (chosen(system))
            kd_schedule_enable(stage->schedule, system->name, enabled);
    }
}

/* Show the moments at which the shutter is open, the last of which is the step that was just made. No time
 * passes, and the schedule's clock shows each of them the step's number, so that rates do not count them. */
static kd_status show_moments(app_stage *stage, uint64_t index)
{
    kd_film *film = kd_singleton(stage->world, kd_film);
    kd_schedule_clock *clock = kd_singleton(stage->world, kd_schedule_clock), after = *clock;
    float open = stage->scene.settings.film_shutter_deg / 360, count = (float)film->sub_frames;
    kd_status status = KD_OK;
    enable(stage, brings_on, false);
    kd_schedule_set_step(stage->schedule, 0);
    kd_singleton(stage->world, kd_frame)->dt_s = 0;
    for (uint32_t i = 0; i < film->sub_frames && status == KD_OK; i++) {
        film->sub_frame = i;
        app_exposure_show(stage->exposure, 1 - open * (count - 1 - (float)i) / count);
        clock->frame = after.frame - 1;
        if (i > 0) /* the first belongs to the step's own */
            app_timing_frame_begin(&stage->timing);
        status = run_systems(stage);
    }
    enable(stage, brings_on, true);
    *clock = after;
    kd_schedule_set_step(stage->schedule, 1 / stage->scene.fps);
    app_scene_show(&stage->scene, index);
    return status;
}

/* The whole step first, without a picture: then both of its ends are known. */
static kd_status film_frame(app_stage *stage, uint64_t index)
{
    app_timing_frame_begin(&stage->timing);
    kd_status status = step(stage, index);
    if (status != KD_OK)
        return status;
    if (!stage->without_gpu)
        enable(stage, is_on_gpu, false);
    status = kd_schedule_run(stage->schedule);
    if (!stage->without_gpu)
        enable(stage, is_on_gpu, true);
    if (status == KD_OK)
        status = app_exposure_note(stage->exposure);
    if (status != KD_OK)
        return status;
    if (!stage->without_gpu)
        return show_moments(stage, index);
    app_timing_section(&stage->timing, APP_ROW_END, true);
    app_timing_frame_end(&stage->timing);
    return KD_OK;
}

kd_status app_stage_frame(app_stage *stage, uint64_t index)
{
    if (stage->exposure)
        return film_frame(stage, index);
    app_timing_frame_begin(&stage->timing);
    kd_status status = step(stage, index);
    return status == KD_OK ? run_systems(stage) : status;
}

kd_status app_stage_again(app_stage *stage, uint64_t index)
{
    kd_schedule_set_step(stage->schedule, 0);
    app_scene_show(&stage->scene, index);
    kd_singleton(stage->world, kd_frame)->dt_s = 0;
    app_timing_frame_begin(&stage->timing);
    kd_status status = run_systems(stage);
    kd_schedule_set_step(stage->schedule, 1 / stage->scene.fps);
    return status;
}

void app_stage_enable_gpu(app_stage *stage, bool enabled)
{
    enable(stage, is_on_gpu, enabled);
    stage->without_gpu = !enabled;
}

void app_stage_close(app_stage *stage)
{
    if (!stage)
        return;
    app_capture_close(stage->capture);
    if (stage->schedule)
        kd_schedule_destroy(stage->schedule);
    app_exposure_destroy(stage->exposure);
    app_timing_close(&stage->timing);
    app_scene_fini(&stage->scene);
    if (stage->world)
        kd_world_destroy(stage->world);
    kd_voxel_file_close(&stage->voxels);
    free(stage);
}
