/* The loop of the window: events, then a simulation step when one is due, else the same step again when
 * something was changed by hand, then the panels; it sleeps while there is nothing to do. */
#include "runtime/app/window/session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/light.h"
#include "components/render_targets.h"
#include "components/transform.h"
#include "runtime/app/console.h"
#include "runtime/app/image_write.h"
#include "runtime/app/interrupt.h"
#include "runtime/core/clock.h"
#include "runtime/core/log.h"

/* Pictures after which light that is reflected again and again is as good as settled; see run.c. */
enum { SETTLING = 21, REDRAWS = 3 };

#define SLOWEST      (1.0 / 64)
#define FASTEST      16.0
#define LOOK_S       0.1  /* how often files are looked at while nothing else happens */
#define MINIMIZED_S  0.25 /* the same while nothing can be seen */
#define LONGEST_DT_S 0.25 /* of a walking camera: a slow picture makes no leap */

static double now_s(void)
{
    return (double)kd_clock_ns() * 1e-9;
}

void window_touch(window_session *s)
{
    s->settling = SETTLING;
    s->redraws = REDRAWS;
}

/* ---- messages ---- */

void window_note(window_session *s, bool error, const char *text)
{
    uint32_t at = (s->message_first + s->message_count) % WINDOW_MESSAGES;
    if (s->message_count == WINDOW_MESSAGES)
        s->message_first = (s->message_first + 1) % WINDOW_MESSAGES;
    else
        s->message_count++;
    s->messages[at].error = error;
    snprintf(s->messages[at].text, sizeof s->messages[at].text, "%s", text);
    s->redraws = REDRAWS;
}

static void listen(void *user, bool error, const char *text)
{
    window_note(user, error, text);
}

/* ---- time ---- */

void window_pause(window_session *s)
{
    s->paused = !s->paused;
    s->steps = 0;
    s->next_step_s = s->now_s;
}

void window_step(window_session *s)
{
    s->paused = true;
    s->steps++;
}

void window_change_speed(window_session *s, double factor)
{
    double speed = s->speed * factor;
    s->speed = speed < SLOWEST ? SLOWEST : speed > FASTEST ? FASTEST : speed;
    s->next_step_s = s->now_s;
}

/* ---- looking ---- */

/* Distance of what stands in the picture's middle: read from its depth, which waits for the GPU. */
double window_interest_m(window_session *s)
{
    const kd_gbuffer *g = kd_singleton(s->stage->world, kd_gbuffer);
    const kd_view *view = kd_singleton(s->stage->world, kd_view);
    size_t count = (size_t)g->width * g->height;
    float *depth = g->depth.id && count ? malloc(count * sizeof *depth) : NULL;
    double distance = 0;
    if (depth) {
        kd_gpu_read_texture(s->gpu, g->depth, 0, depth, count * sizeof *depth);
        double z = 2 * (double)depth[count / 2 + g->width / 2] - 1, n = view->z_near, f = view->z_far;
        if (z < 0.99999 && view->tan_half_fov_y > 0)
            distance = 2 * f * n / (f + n - z * (f - n));
    }
    free(depth);
    if (distance <= 0) { /* the sky, or parallel rays: as far as the middle of the world */
        distance = kd_vec3_length(view->position_ws);
        distance = distance > 1 ? distance : 1;
    }
    return distance;
}

void window_set_camera(window_session *s, window_camera_mode mode)
{
    window_camera_set(&s->camera, mode, kd_singleton(s->stage->world, kd_view), (float)window_interest_m(s));
    window_touch(s);
}

void window_screenshot(window_session *s)
{
    char path[KD_PATH_MAX], said[KD_PATH_MAX + 16], scene[128];
    const kd_picture *picture = kd_singleton(s->stage->world, kd_picture);
    size_t size = (size_t)picture->width * picture->height * 4;
    uint8_t *rgba = size ? malloc(size) : NULL;
    const char *name = kd_path_name(s->subject);
    if (!rgba)
        return;
    snprintf(scene, sizeof scene, "%.*s", (int)(strlen(name) - strlen(kd_path_extension(name))), name);
    for (unsigned n = 1; n < 10000; n++) {
        snprintf(path, sizeof path, "%s_%llu_%u.png", scene,
                 (unsigned long long)(s->frame ? s->frame - 1 : 0), n);
        if (!kd_file_exists(path))
            break;
    }
    kd_gpu_barrier(s->gpu, KD_BARRIER_TEXTURE_UPDATE);
    kd_gpu_read_texture(s->gpu, picture->ldr, 0, rgba, size);
    if (app_png_write(path, picture->width, picture->height, rgba) == KD_OK) {
        snprintf(said, sizeof said, "wrote %s", path);
        kd_log(KD_LOG_INFO, "%s", said);
        window_note(s, false, said);
    }
    app_console_recover();
    free(rgba);
}

/* ---- opening ---- */

kd_status window_stage_begin(window_session *s)
{
    kd_world *w = s->stage->world;
    s->lamps = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(kd_light)}, .name = "panel of lights"});
    s->everything = kd_query_make(w, &(kd_query_desc){.terms = {KD_OPTIONAL(kd_transform)},
                                                      .by_depth = true,
                                                      .name = "panel of the scene"});
    if (!s->lamps || !s->everything)
        return kd_fail(KD_NO_MEMORY, "out of memory for the window's panels");
    return window_history_open(&s->history, s->stage->timing.profile);
}

void window_stage_end(window_session *s)
{
    if (s->lamps)
        kd_query_destroy(s->lamps);
    if (s->everything)
        kd_query_destroy(s->everything);
    s->lamps = s->everything = NULL;
    s->chosen = KD_NO_ENTITY;
}

static kd_status open_session(window_session *s, const app_window_desc *desc)
{
    *s = (window_session){.desc = desc,
                          .options = *desc->options,
                          .stage = *desc->stage,
                          .gpu = desc->gpu,
                          .speed = 1,
                          .coarseness = 1,
                          .panels = true,
                          .redraws = REDRAWS};
    snprintf(s->subject, sizeof s->subject, "%s", desc->options->subject);
    s->options.subject = s->subject;
    s->keeps_size = desc->options->output_count > 0;
    s->open[WINDOW_PANEL_RUN] = true;
    kd_status status = kd_ui_open(s->gpu, &s->ui);
    if (status == KD_OK)
        status = window_stage_begin(s);
    if (status != KD_OK)
        return status;
    app_console_listen(listen, s);
    s->watch = window_watch_make();
    window_watch_files(s); /* before the first picture: whoever sees it may edit at once */
    window_list_scenes(s);
    return KD_OK;
}

static void close_session(window_session *s)
{
    app_console_listen(NULL, NULL);
    window_watch_destroy(s->watch);
    window_stage_end(s);
    free((void *)s->kept_sets);
    window_history_close(&s->history);
    kd_ui_close(s->ui);
    for (uint32_t i = 0; i < s->scene_count; i++)
        free(s->scenes[i]);
}

/* ---- a turn of the loop ---- */

/* Frames that are asked for by number are made as fast as they can be. */
static bool is_hurried(const window_session *s)
{
    return s->desc->frame_count != UINT64_MAX;
}

static bool step_is_due(const window_session *s)
{
    if (s->stopped)
        return false;
    if (s->paused)
        return s->steps > 0;
    return is_hurried(s) || s->now_s >= s->next_step_s;
}

static bool can_be_seen(const window_session *s)
{
    return s->width > 0 && s->height > 0 && !kd_gpu_window_minimized(s->gpu);
}

static bool has_work(const window_session *s)
{
    return can_be_seen(s) && (step_is_due(s) || (s->settling && !s->stopped) || s->redraws ||
                              kd_ui_waiting(s->ui) || window_camera_goes(&s->camera));
}

static void wait_for_work(window_session *s)
{
    double wait_s = 0;
    s->now_s = now_s();
    if (!has_work(s)) {
        wait_s = can_be_seen(s) ? LOOK_S : MINIMIZED_S;
        if (can_be_seen(s) && !s->paused && !s->stopped && s->next_step_s - s->now_s < wait_s)
            wait_s = s->next_step_s - s->now_s;
    }
    kd_gpu_window_wait(s->gpu, wait_s > 0 ? wait_s : 0);
}

/* The picture has as many pixels as the window, unless it is written to files. */
static void fit_picture(window_session *s)
{
    uint32_t width, height;
    app_scene *scene = &s->stage->scene;
    kd_gpu_window_size(s->gpu, &width, &height);
    if (width != s->width || height != s->height)
        s->redraws = REDRAWS;
    s->width = width;
    s->height = height;
    if (s->keeps_size || !width || !height)
        return;
    width = (width + s->coarseness - 1) / s->coarseness;
    height = (height + s->coarseness - 1) / s->coarseness;
    if (width == scene->width && height == scene->height)
        return;
    scene->width = width;
    scene->height = height;
    window_touch(s);
}

static void place_camera(window_session *s)
{
    kd_free_camera *place = kd_singleton(s->stage->world, kd_free_camera);
    place->on = s->camera.mode != WINDOW_CAMERA_FIXED;
    place->world = window_camera_world(&s->camera);
    if (s->camera.turned)
        window_touch(s);
    s->camera.turned = false;
}

/* What went wrong in a step can mostly be mended in its file: the last picture stays. A GPU that fails
 * cannot.
 */
static kd_status judge(window_session *s, kd_status status)
{
    if (status == KD_GPU && s->broken_shaders) {
        kd_gpu_forgive(s->gpu); /* a program was made of one that does not compile */
        status = KD_BAD_FORMAT;
    }
    if (status == KD_OK || status == KD_INTERRUPTED || status == KD_GPU || status == KD_NO_MEMORY)
        return status;
    s->stopped = true;
    s->alarm = true;
    s->settling = 0;
    app_console_recover();
    return KD_OK;
}

static kd_status make_step(window_session *s)
{
    kd_status status = app_stage_frame(s->stage, s->frame);
    double period_s = 1 / (s->stage->scene.fps * s->speed);
    s->frame += status == KD_OK;
    s->steps -= s->steps > 0;
    s->settling -= s->settling > 0;
    s->next_step_s += period_s;
    if (s->next_step_s < s->now_s) /* too slow for real time: simulated time stretches */
        s->next_step_s = s->now_s;
    return status;
}

static kd_status make_picture(window_session *s)
{
    kd_status status = KD_OK;
    if (step_is_due(s)) {
        status = make_step(s);
    } else if (s->settling && !s->stopped && s->frame > 0) {
        status = app_stage_again(s->stage, s->frame - 1);
        s->settling--;
    } else {
        return KD_OK;
    }
    if (status == KD_OK)
        window_history_add(&s->history, s->stage->timing.profile);
    s->redraws = s->redraws ? s->redraws : 1;
    return judge(s, status);
}

static void draw(window_session *s)
{
    const kd_picture *picture = kd_singleton(s->stage->world, kd_picture);
    if (picture->ldr.id)
        kd_gpu_blit_to_window(s->gpu, picture->ldr, s->width, s->height);
    kd_ui_begin(s->ui, (float)(s->now_s - s->drawn_s));
    s->drawn_s = s->now_s;
    s->redraws -= s->redraws > 0;
    window_draw_panels(s);
    kd_ui_end(s->ui);
    kd_gpu_window_present(s->gpu);
    kd_gpu_end_frame(s->gpu);
}

static void advance_camera(window_session *s, double before_s)
{
    double dt_s = s->now_s - before_s;
    window_camera_advance(&s->camera, (float)(dt_s < LONGEST_DT_S ? dt_s : LONGEST_DT_S));
    place_camera(s);
}

static kd_status make_turn(window_session *s)
{
    double before_s = s->now_s;
    wait_for_work(s);
    s->now_s = now_s();
    window_take_events(s);
    fit_picture(s);
    kd_status status = window_switch(s);
    advance_camera(s, before_s);
    if (status != KD_OK || !can_be_seen(s))
        return status;
    status = make_picture(s);
    if (status == KD_OK && (s->redraws || kd_ui_waiting(s->ui)))
        draw(s);
    return status == KD_OK && kd_gpu_failed(s->gpu) ? KD_GPU : status;
}

kd_status app_window_run(const app_window_desc *desc, uint64_t *done)
{
    static window_session s; /* large, and one at a time */
    kd_status status = open_session(&s, desc);
    while (status == KD_OK && s.frame < desc->frame_count && !kd_gpu_window_closing(s.gpu)) {
        status = app_interrupted() ? KD_INTERRUPTED : make_turn(&s);
        if (is_hurried(&s) && status == KD_OK)
            app_console_progress(s.frame, desc->frame_count, 0);
    }
    *done = s.frame;
    *desc->stage = s.stage;
    close_session(&s);
    return status;
}
