/* Keys and mouse: the panels come first, then the window's own keys, then the camera and the scenario. */
#include <stdio.h>
#include <string.h>

#include "runtime/app/window/session.h"

/* ---- what keys do ---- */

static void do_pause(window_session *s, int argument)
{
    (void)argument;
    window_pause(s);
}

static void do_step(window_session *s, int argument)
{
    (void)argument;
    window_step(s);
}

static void do_speed(window_session *s, int argument)
{
    window_change_speed(s, argument > 0 ? 2 : 0.5);
}

static void do_camera(window_session *s, int argument)
{
    int mode = (int)s->camera.mode + argument + WINDOW_CAMERA_MODES;
    window_set_camera(s, (window_camera_mode)(mode % WINDOW_CAMERA_MODES));
}

static void do_fixed_camera(window_session *s, int argument)
{
    (void)argument;
    window_set_camera(s, WINDOW_CAMERA_FIXED);
}

static void do_scene(window_session *s, int argument)
{
    window_next_scene(s, argument);
}

static void do_technique(window_session *s, int argument)
{
    int count = 0, gi = (int)s->stage->scene.gi + argument;
    while (app_gi_words[count])
        count++;
    s->stage->scene.gi = (uint32_t)((gi + count) % count);
    window_touch(s);
}

static void change_number(window_session *s, const char *key, int by)
{
    char assignment[64];
    kd_settings *settings = &s->stage->scene.settings;
    const kd_setting_row *row = kd_settings_find(key, strlen(key));
    if (!row)
        return;
    double value = kd_settings_value(settings, row) + by;
    if (value < row->min || value > row->max)
        return;
    if (row->type == KD_SETTING_ENUM)
        snprintf(assignment, sizeof assignment, "%s=%s", key, row->words[(size_t)value]);
    else
        snprintf(assignment, sizeof assignment, "%s=%d", key, (int)value);
    (void)kd_settings_set(settings, assignment);
    window_touch(s);
}

static void do_level(window_session *s, int argument)
{
    change_number(s, "view.level", argument);
}

static void do_channel(window_session *s, int argument)
{
    change_number(s, "view.channel", argument);
}

static void do_panels(window_session *s, int argument)
{
    (void)argument;
    s->panels = !s->panels;
}

static void do_panel(window_session *s, int argument)
{
    s->panels = true;
    s->open[argument] = !s->open[argument];
}

static void do_screenshot(window_session *s, int argument)
{
    (void)argument;
    window_screenshot(s);
}

static void do_reload(window_session *s, int argument)
{
    (void)argument;
    s->reload_asked = true;
}

static void do_close(window_session *s, int argument)
{
    (void)argument;
    kd_gpu_window_close(s->gpu);
}

/* Keys of the number pad are those of the paper. Plain keys that a scenario may want are left to it when it
 * asks for keys at all. */
static const struct {
    int key;
    uint32_t modifiers;
    bool plain;
    void (*act)(window_session *s, int argument);
    int argument;
} bindings[] = {
    {KD_KEY_KP_1, 0, false, do_camera, -1},
    {KD_KEY_KP_3, 0, false, do_camera, 1},
    {KD_KEY_KP_2, 0, false, do_fixed_camera, 0},
    {KD_KEY_KP_4, 0, false, do_scene, -1},
    {KD_KEY_KP_5, 0, false, do_scene, 1},
    {KD_KEY_KP_6, 0, false, do_scene, 1},
    {KD_KEY_KP_7, 0, false, do_technique, -1},
    {KD_KEY_KP_9, 0, false, do_technique, 1},
    {KD_KEY_KP_ADD, 0, false, do_level, 1},
    {KD_KEY_KP_SUBTRACT, 0, false, do_level, -1},
    {KD_KEY_KP_MULTIPLY, 0, false, do_channel, 1},
    {KD_KEY_KP_DIVIDE, 0, false, do_channel, -1},
    {KD_KEY_F1, 0, false, do_panels, 0},
    {KD_KEY_F2, 0, false, do_camera, 1},
    {KD_KEY_F5, 0, false, do_reload, 0},
    {KD_KEY_F6, 0, false, do_pause, 0},
    {KD_KEY_F7, 0, false, do_step, 0},
    {KD_KEY_F8, 0, false, do_speed, -1},
    {KD_KEY_F9, 0, false, do_speed, 1},
    {KD_KEY_F12, 0, false, do_screenshot, 0},
    {KD_KEY_PAGE_UP, KD_MOD_CONTROL, false, do_scene, -1},
    {KD_KEY_PAGE_DOWN, KD_MOD_CONTROL, false, do_scene, 1},
    {KD_KEY_R, KD_MOD_CONTROL, false, do_reload, 0},
    {KD_KEY_Q, KD_MOD_CONTROL, false, do_close, 0},
    {KD_KEY_SPACE, 0, true, do_pause, 0},
    {KD_KEY_PERIOD, 0, true, do_step, 0},
    {KD_KEY_1, KD_MOD_CONTROL, false, do_panel, 0},
    {KD_KEY_2, KD_MOD_CONTROL, false, do_panel, 1},
    {KD_KEY_3, KD_MOD_CONTROL, false, do_panel, 2},
    {KD_KEY_4, KD_MOD_CONTROL, false, do_panel, 3},
    {KD_KEY_5, KD_MOD_CONTROL, false, do_panel, 4},
    {KD_KEY_6, KD_MOD_CONTROL, false, do_panel, 5},
    {KD_KEY_7, KD_MOD_CONTROL, false, do_panel, 6},
    {KD_KEY_8, KD_MOD_CONTROL, false, do_panel, 7},
};
_Static_assert(WINDOW_PANEL_COUNT == 8, "every panel has its key");

static bool run_binding(window_session *s, const kd_window_event *e)
{
    bool taken = s->stage->scene.script && kd_script_listens(s->stage->scene.script, KD_SCRIPT_ON_KEY);
    for (size_t i = 0; i < sizeof bindings / sizeof *bindings; i++) {
        if (bindings[i].key != e->code || bindings[i].modifiers != e->modifiers ||
            (bindings[i].plain && taken))
            continue;
        if (e->down && (!e->repeat || bindings[i].act == do_step))
            bindings[i].act(s, bindings[i].argument);
        return true;
    }
    return false;
}

/* ---- the scenario ---- */

static void tell_scenario(window_session *s, const kd_window_event *e)
{
    static const char *const buttons[KD_MOUSE_COUNT] = {"left", "right", "middle"};
    kd_script *script = s->stage->scene.script;
    float width = (float)(s->width ? s->width : 1), height = (float)(s->height ? s->height : 1);
    kd_script_input input = {.down = e->down, .x = e->x / width, .y = e->y / height};
    if (!script || e->repeat)
        return;
    switch (e->kind) {
    case KD_WINDOW_KEY:
        input.kind = KD_SCRIPT_ON_KEY;
        input.name = kd_key_name(e->code);
        break;
    case KD_WINDOW_BUTTON:
        input.kind = KD_SCRIPT_ON_MOUSE;
        input.name = buttons[e->code];
        break;
    case KD_WINDOW_POINTER: input.kind = KD_SCRIPT_ON_MOUSE_MOVE; break;
    case KD_WINDOW_SCROLL:
        input.kind = KD_SCRIPT_ON_SCROLL;
        input.x = e->x;
        input.y = e->y;
        break;
    default: return;
    }
    if (input.name || e->kind == KD_WINDOW_POINTER || e->kind == KD_WINDOW_SCROLL)
        kd_script_push_input(script, &input);
}

/* ---- events ---- */

static void take(window_session *s, const kd_window_event *e)
{
    bool released = (e->kind == KD_WINDOW_KEY || e->kind == KD_WINDOW_BUTTON) && !e->down;
    s->redraws = s->redraws > 3 ? s->redraws : 3;
    if (e->kind == KD_WINDOW_FOCUS && !e->down)
        window_camera_release(&s->camera);
    if (s->panels && kd_ui_event(s->ui, e)) {
        if (released) /* it may have been pressed elsewhere */
            window_camera_event(&s->camera, e, kd_singleton(s->stage->world, kd_view));
        return;
    }
    if (e->kind == KD_WINDOW_KEY && run_binding(s, e))
        return;
    window_camera_event(&s->camera, e, kd_singleton(s->stage->world, kd_view));
    tell_scenario(s, e);
}

void window_take_events(window_session *s)
{
    kd_window_event event;
    while (kd_gpu_window_event(s->gpu, &event))
        take(s, &event);
}
