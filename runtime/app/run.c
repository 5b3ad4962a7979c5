/* `kandil run`: load the scene, open the GPU, run the frames, write what was asked for. */
#include "runtime/app/run.h"

#include <stdio.h>

#include "components/voxel_scene.h"
#include "runtime/app/capture.h"
#include "runtime/app/console.h"
#include "runtime/app/graph.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/stage.h"
#include "runtime/app/stats.h"
#include "runtime/app/window/window.h"
#include "runtime/app/world_setup.h"
#include "runtime/core/clock.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/core/progress.h"

typedef struct run {
    const app_options *options;
    kd_jobs *jobs;
    kd_gpu *gpu;
    app_stage *stage;
    uint64_t frame_count, done, left_out;
    bool without_gpu;       /* GPU systems are switched off: the frame is there already */
    uint64_t work_began_ns; /* of what kd_progress tells */
    bool cut;               /* an interrupt ended a frame's voxelization: that frame is not shown */
} run;

/* ---- before the frames ---- */

/* Find out what would fail at the end. */
static kd_status check_outputs(const app_options *o)
{
    kd_file_out probe;
    kd_status status = app_capture_check(o);
    if (status == KD_OK && o->stats) {
        status = kd_file_out_open(&probe, o->stats);
        if (status == KD_OK)
            kd_file_out_cancel(&probe);
    }
    for (uint32_t i = 0; i < o->trace_count && status == KD_OK; i++) {
        status = kd_file_out_open(&probe, o->traces[i]);
        if (status == KD_OK)
            kd_file_out_cancel(&probe);
    }
    if (status == KD_OK && o->compare_profile)
        status = kd_profile_check_old(o->compare_profile);
    return status == KD_OK && o->graph ? app_graph_check(o->graph) : status;
}

static kd_status open_gpu(run *r)
{
    return kd_gpu_open(
        &(kd_gpu_desc){
            .api = r->options->context,
            .window = r->options->window,
            .width = r->stage->scene.width,
            .height = r->stage->scene.height,
            .shaders = app_shaders(r->options->extension),
#ifndef NDEBUG
            .debug = true,
#endif
        },
        &r->gpu);
}

/* Timing each system costs a little: only when someone will look. */
static app_timing_mode timing_mode(const run *r)
{
    const app_options *o = r->options;
    if (!o->profile && !o->stats && !o->trace_count && !o->compare_profile && !o->window)
        return APP_TIMING_OFF;
    return r->options->profile_sync || kd_gpu_get_info(r->gpu)->software ? APP_TIMING_SYNC
                                                                         : APP_TIMING_STAMPS;
}

static app_stage_desc stage_desc(const run *r)
{
    return (app_stage_desc){
        .gpu = r->gpu, .timing = timing_mode(r), .trace = r->options->trace_count > 0, .captures = true};
}

static kd_status open_all(run *r)
{
    kd_status status = check_outputs(r->options);
    if (status != KD_OK)
        return status;
    r->jobs = kd_jobs_make(r->options->threads);
    if (!r->jobs)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    status = app_stage_load(r->options, r->jobs, NULL, &r->stage);
    if (status == KD_OK)
        status = open_gpu(r);
    if (status == KD_OK) {
        app_stage_desc desc = stage_desc(r);
        status = app_stage_open(r->stage, &desc);
    }
    return status;
}

/* ---- the frames ---- */

/* A file that was asked for and holds nothing of what the first frame shows is of something else. */
static kd_status check_voxels(const run *r)
{
    const kd_voxel_scene *scene = kd_singleton(r->stage->world, kd_voxel_scene);
    if (!scene->given || !scene->cache_count || scene->given_used)
        return KD_OK;
    return kd_fail(KD_BAD_FORMAT,
                   "%s: it is stale: none of its voxels are of this scene at these spans; make it again with "
                   "`kandil voxelize`",
                   r->options->voxels);
}

/* ---- frames that are there already ---- */

/* Frames rendered before one that is wanted. What the GPU keeps from frame to frame changes no picture but
 * for light that goes on being reflected and pictures that are mixed with those before: after this many frames
 * less than a hundredth of what is missing is left, with surfaces that reflect eight tenths. */
enum { FIRST_FRAMES = 1, WARM_UP_FRAMES = 2, BOUNCE_FRAMES = 21 };

static uint64_t warm_up_frames(const run *r)
{
    const kd_settings *s = &r->stage->scene.settings;
    return s->light_bounces > KD_BOUNCES_ONE || s->view_steady ? BOUNCE_FRAMES : WARM_UP_FRAMES;
}

static bool is_finished(const run *r, uint64_t frame)
{
    return frame < r->frame_count &&
           !app_capture_wants(r->stage->capture, frame, frame + 1 == r->frame_count);
}

/* Neither the frame nor those for which it would warm up are wanted. The first is rendered in any case: what
 * is made once, such as the voxels of a skin, starts from its pose. */
static bool may_leave_out(const run *r, uint64_t frame)
{
    if (frame < FIRST_FRAMES)
        return false;
    for (uint64_t i = frame; i <= frame + warm_up_frames(r) && i < r->frame_count; i++)
        if (!is_finished(r, i))
            return false;
    return true;
}

/* The simulation goes through every frame, the GPU through those that are wanted. */
static void choose_work(run *r)
{
    bool without_gpu = may_leave_out(r, r->done);
    app_capture_rest(r->stage->capture, is_finished(r, r->done));
    r->left_out += without_gpu;
    if (without_gpu != r->without_gpu)
        app_stage_enable_gpu(r->stage, !without_gpu);
    r->without_gpu = without_gpu;
}

/* Voxelization at the start may take long: it has a bar of its own from the first second on, and ends when it
 * is interrupted. Nobody is shown the frame that lacks the rest. */
static bool follow_work(void *user, uint64_t done, uint64_t total, const char *what)
{
    run *r = user;
    uint64_t now = kd_clock_ns();
    if (done == 0)
        r->work_began_ns = now;
    if (now - r->work_began_ns > 1000000000u)
        app_console_bar(done, total, what);
    if (!app_interrupted())
        return true;
    r->cut = true;
    app_capture_rest(r->stage->capture, true);
    return false;
}

static kd_status run_frames(run *r)
{
    kd_status status = KD_OK;
    while (status == KD_OK && r->done < r->frame_count) {
        if (app_interrupted())
            return KD_INTERRUPTED;
        uint64_t began = kd_clock_ns();
        if (r->options->resume)
            choose_work(r);
        status = app_stage_frame(r->stage, r->done);
        if (status == KD_OK && r->cut)
            return KD_INTERRUPTED;
        if (status == KD_OK && r->done == 0)
            status = check_voxels(r);
        r->done += status == KD_OK;
        app_console_progress(r->done, r->frame_count, (double)(kd_clock_ns() - began) * 1e-6);
    }
    return status;
}

/* A window stays until it is closed, unless so many frames were asked for. */
static kd_status run_window(run *r)
{
    bool endless = r->options->frames < 0 && r->options->seconds < 0;
    return app_window_run(&(app_window_desc){.options = r->options,
                                             .jobs = r->jobs,
                                             .gpu = r->gpu,
                                             .stage = &r->stage,
                                             .reopen = stage_desc(r),
                                             .frame_count = endless ? UINT64_MAX : r->frame_count},
                          &r->done);
}

/* ---- after the frames ---- */

/* An interrupted run keeps its frames and shows the last one; a failed run keeps the frames alone. */
static kd_status finish(run *r, kd_status status)
{
    app_console_clear();
    app_timing_finish(&r->stage->timing);
    if (r->left_out)
        kd_log(KD_LOG_INFO, "resumed: %llu of %llu frames were not rendered again",
               (unsigned long long)r->left_out, (unsigned long long)r->done);
    bool last = r->done > 0 && (status == KD_OK || status == KD_INTERRUPTED);
    kd_status written = app_capture_finish(r->stage->capture, last);
    if (status == KD_OK || status == KD_INTERRUPTED)
        status = written != KD_OK ? written : status;
    if ((status == KD_OK || status == KD_INTERRUPTED) && r->options->stats) {
        written =
            app_stats_write(r->options->stats, &r->stage->scene, &r->stage->timing, r->gpu, r->jobs, r->done);
        status = written != KD_OK ? written : status;
    }
    if (r->options->graph && r->done > 0 && (status == KD_OK || status == KD_INTERRUPTED)) {
        written = app_graph_write(r->stage->schedule, r->options->graph);
        status = written != KD_OK ? written : status;
    }
    if (status == KD_OK && r->done == 0 && r->options->output_count)
        kd_log(KD_LOG_WARNING, "%s was not written: no frame was rendered; ask for one at least",
               r->options->outputs[0].path);
    if (r->options->profile && r->done > 0)
        kd_profile_write_table(r->stage->timing.profile, stdout);
    if (r->options->compare_profile && r->done > 0) {
        written = kd_profile_compare(r->stage->timing.profile, r->options->compare_profile, stdout);
        status = status == KD_OK ? written : status;
    }
    for (uint32_t i = 0; i < r->options->trace_count && r->done > 0; i++) {
        written = kd_profile_write_trace(r->stage->timing.profile, r->options->traces[i]);
        status = status == KD_OK ? written : status;
    }
    return status;
}

static void close_all(run *r)
{
    app_stage_close(r->stage);
    if (r->gpu)
        kd_gpu_close(r->gpu);
    if (r->jobs)
        kd_jobs_destroy(r->jobs);
}

kd_status app_run(const app_options *options)
{
    run r = {.options = options};
    app_interrupt_install();
    kd_status status = open_all(&r);
    if (status == KD_OK) {
        r.frame_count = app_scene_frames(&r.stage->scene, options);
        if (options->graph && r.frame_count == 0 && !options->window)
            status = kd_fail(KD_USAGE, "--graph: %s: the graph is known after a frame; render one at least",
                             options->graph);
        else {
            if (!options->window)
                kd_progress_set_sink(follow_work, &r);
            status = finish(&r, options->window ? run_window(&r) : run_frames(&r));
            kd_progress_set_sink(NULL, NULL);
        }
    }
    close_all(&r);
    if (status == KD_INTERRUPTED)
        kd_log(KD_LOG_INFO, "interrupted after %llu frames; what was finished is kept",
               (unsigned long long)r.done);
    return status;
}
