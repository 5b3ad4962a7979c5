/* How time passes, how the scene is looked at, which scene is on. */
#include <stdio.h>
#include <string.h>

#include "runtime/app/window/session.h"

static void draw_time(window_session *s)
{
    char label[32];
    if (kd_ui_button(s->ui, s->paused ? "Go on" : "Pause"))
        window_pause(s);
    kd_ui_same_line(s->ui);
    if (kd_ui_button(s->ui, "Step"))
        window_step(s);
    kd_ui_same_line(s->ui);
    if (kd_ui_button(s->ui, "Slower"))
        window_change_speed(s, 0.5);
    kd_ui_same_line(s->ui);
    if (kd_ui_button(s->ui, "Faster"))
        window_change_speed(s, 2);
    if (s->speed >= 1)
        snprintf(label, sizeof label, "%.0f x", s->speed);
    else
        snprintf(label, sizeof label, "1/%.0f x", 1 / s->speed);
    kd_ui_text(s->ui, "frame %llu, %.2f s, speed %s", (unsigned long long)s->frame,
               (double)s->frame / s->stage->scene.fps, label);
}

static void draw_camera(window_session *s)
{
    uint32_t mode = (uint32_t)s->camera.mode;
    if (kd_ui_choose(s->ui, "camera", window_camera_words, WINDOW_CAMERA_MODES, &mode))
        window_set_camera(s, (window_camera_mode)mode);
    kd_ui_hint(s->ui,
               "orbit: drag to turn, right button to move, wheel to come nearer\nwalk: drag to look, W A S D "
               "Q E to go, Shift to run");
    kd_vec3 p = s->camera.mode == WINDOW_CAMERA_FIXED ? kd_singleton(s->stage->world, kd_view)->position_ws
                                                      : s->camera.position;
    kd_ui_text_dim(s->ui, "at %.2f, %.2f, %.2f", (double)p.x, (double)p.y, (double)p.z);
}

static void draw_scene(window_session *s)
{
    uint32_t index = 0;
    while (index < s->scene_count && strcmp(s->scenes[index], kd_path_name(s->subject)) != 0)
        index++;
    if (kd_ui_choose(s->ui, "scene", (const char *const *)s->scenes, s->scene_count, &index))
        window_choose_scene(s, index);
    if (kd_ui_button(s->ui, "Load anew"))
        s->reload_asked = true;
    kd_ui_same_line(s->ui);
    if (kd_ui_button(s->ui, "Screenshot"))
        window_screenshot(s);
}

void window_panel_run(window_session *s)
{
    double coarseness = s->coarseness;
    draw_time(s);
    kd_ui_separator(s->ui);
    draw_camera(s);
    kd_ui_separator(s->ui);
    draw_scene(s);
    kd_ui_disabled_begin(s->ui, s->keeps_size);
    if (kd_ui_numbers(s->ui, "coarseness", &coarseness, 1, 0.02, 1, 8, true))
        s->coarseness = (uint32_t)coarseness;
    kd_ui_hint(s->ui, "window pixels per pixel of the picture, along an axis");
    kd_ui_disabled_end(s->ui);
}
