/* The bar at the top and the panels under it; also the widgets for settings that several panels use. */
#include <stdio.h>
#include <string.h>

#include "runtime/app/window/session.h"

static const struct {
    const char *title, *key;
    void (*draw)(window_session *s);
    float x, y, width, height; /* at first; a negative x counts from the right, a negative y from below */
} panels[WINDOW_PANEL_COUNT] = {
    [WINDOW_PANEL_RUN] = {"Run", "Ctrl+1", window_panel_run, 6, 26, 232, 178},
    [WINDOW_PANEL_SCENE] = {"Scene", "Ctrl+2", window_panel_scene, 6, 26, 300, 420},
    [WINDOW_PANEL_LIGHTS] = {"Lights", "Ctrl+3", window_panel_lights, -306, 26, 300, 260},
    [WINDOW_PANEL_VOXELS] = {"Voxels", "Ctrl+4", window_panel_voxels, -326, 26, 320, 300},
    [WINDOW_PANEL_CONES] = {"Cones", "Ctrl+5", window_panel_cones, -306, 26, 300, 270},
    [WINDOW_PANEL_VIEW] = {"View", "Ctrl+6", window_panel_view, -286, 26, 280, 230},
    [WINDOW_PANEL_PROFILE] = {"Profile", "Ctrl+7", window_panel_profile, -386, 26, 380, 330},
    [WINDOW_PANEL_MESSAGES] = {"Messages", "Ctrl+8", window_panel_messages, 6, -126, 520, 120},
};

/* ---- settings ---- */

static void write_setting(window_session *s, const kd_setting_row *row, const char *value)
{
    char assignment[128];
    snprintf(assignment, sizeof assignment, "%s=%s", row->key, value);
    if (kd_settings_set(&s->stage->scene.settings, assignment) == KD_OK)
        window_touch(s);
}

static void edit_number(window_session *s, const kd_setting_row *row, const char *label)
{
    char text[32];
    double value = kd_settings_value(&s->stage->scene.settings, row);
    bool whole = row->type == KD_SETTING_I32;
    double range = row->max - row->min, speed = whole ? 0.05 : range < 20 ? range * 0.003 : 0.02;
    if (!kd_ui_numbers(s->ui, label, &value, 1, speed, row->min, row->max, whole))
        return;
    snprintf(text, sizeof text, whole ? "%.0f" : "%.9g", value);
    write_setting(s, row, text);
}

/* One of the words; a number that may have some values only is chosen like a word. */
static void edit_word(window_session *s, const kd_setting_row *row, const char *label)
{
    char now[32];
    uint32_t count = 0, index = 0;
    kd_settings_format(&s->stage->scene.settings, row, now, sizeof now);
    for (; row->words[count]; count++)
        if (strcmp(row->words[count], now) == 0)
            index = count;
    if (kd_ui_choose(s->ui, label, row->words, count, &index))
        write_setting(s, row, row->words[index]);
}

static void edit_setting(window_session *s, const kd_setting_row *row)
{
    char label[96];
    snprintf(label, sizeof label, "%s%s%s%s##%s", strchr(row->key, '.') + 1, row->unit ? " [" : "",
             row->unit ? row->unit : "", row->unit ? "]" : "", row->key);
    if (row->type == KD_SETTING_BOOL) {
        bool value = kd_settings_value(&s->stage->scene.settings, row) != 0;
        if (kd_ui_check(s->ui, label, &value))
            write_setting(s, row, value ? "on" : "off");
    } else if (row->words) {
        edit_word(s, row, label);
    } else {
        edit_number(s, row, label);
    }
    kd_ui_hint(s->ui, row->doc);
}

void window_setting(window_session *s, const char *key)
{
    const kd_setting_row *row = kd_settings_find(key, strlen(key));
    if (row)
        edit_setting(s, row);
}

void window_settings(window_session *s, const char *group)
{
    size_t count, length = strlen(group);
    const kd_setting_row *rows = kd_settings_rows(&count);
    for (size_t i = 0; i < count; i++)
        if (strncmp(rows[i].key, group, length) == 0 && rows[i].key[length] == '.')
            edit_setting(s, &rows[i]);
}

const char *window_bytes(uint64_t bytes, char out[16])
{
    static const char *const units[] = {"B", "kB", "MB", "GB"};
    double value = (double)bytes;
    int unit = 0;
    for (; value >= 1000 && unit < 3; unit++)
        value /= 1000;
    snprintf(out, 16, unit && value < 100 ? "%.1f %s" : "%.0f %s", value, units[unit]);
    return out;
}

/* ---- the bar ---- */

static void draw_scene_menu(window_session *s)
{
    if (!kd_ui_menu_begin(s->ui, "Scene"))
        return;
    for (uint32_t i = 0; i < s->scene_count; i++)
        if (kd_ui_menu_item(s->ui, s->scenes[i], NULL, strcmp(s->scenes[i], kd_path_name(s->subject)) == 0))
            window_choose_scene(s, i);
    kd_ui_separator(s->ui);
    if (kd_ui_menu_item(s->ui, "Load anew", "F5", false))
        s->reload_asked = true;
    if (kd_ui_menu_item(s->ui, "Screenshot", "F12", false))
        window_screenshot(s);
    if (kd_ui_menu_item(s->ui, "Close", "Ctrl+Q", false))
        kd_gpu_window_close(s->gpu);
    kd_ui_menu_end(s->ui);
}

static void draw_camera_menu(window_session *s)
{
    static const char *const words[WINDOW_CAMERA_MODES] = {"Fixed: the scene's own", "Orbit", "Walk"};
    if (!kd_ui_menu_begin(s->ui, "Camera"))
        return;
    for (int i = 0; i < WINDOW_CAMERA_MODES; i++)
        if (kd_ui_menu_item(s->ui, words[i], i == 0 ? "F2" : NULL, (int)s->camera.mode == i))
            window_set_camera(s, (window_camera_mode)i);
    kd_ui_menu_end(s->ui);
}

static void draw_panels_menu(window_session *s)
{
    if (!kd_ui_menu_begin(s->ui, "Panels"))
        return;
    for (int i = 0; i < WINDOW_PANEL_COUNT; i++)
        if (kd_ui_menu_item(s->ui, panels[i].title, panels[i].key, s->open[i]))
            s->open[i] = !s->open[i];
    kd_ui_separator(s->ui);
    if (kd_ui_menu_item(s->ui, "Hide all", "F1", false))
        s->panels = false;
    kd_ui_menu_end(s->ui);
}

static void draw_bar(window_session *s)
{
    if (!kd_ui_bar_begin(s->ui))
        return;
    draw_scene_menu(s);
    draw_camera_menu(s);
    draw_panels_menu(s);
    window_history_stats frame = window_history_read(&s->history, s->history.row_count - 1);
    kd_ui_text_dim(s->ui, "  frame %llu  %.2f s  %.1f ms%s%s", (unsigned long long)s->frame,
                   (double)s->frame / s->stage->scene.fps, (double)frame.median_ms,
                   s->paused ? "  paused" : "", s->stopped ? "  stopped" : "");
    kd_ui_bar_end(s->ui);
}

/* ---- all of them ---- */

static void draw_panel(window_session *s, int i)
{
    float width, height;
    kd_ui_size(s->ui, &width, &height);
    float x = panels[i].x < 0 ? width + panels[i].x : panels[i].x;
    float y = panels[i].y < 0 ? height + panels[i].y : panels[i].y;
    float room = height - y - 6;
    float tall = panels[i].height < room ? panels[i].height : room > 80 ? room : 80;
    if (kd_ui_panel_begin(s->ui, panels[i].title, x > 0 ? x : 0, y, panels[i].width, tall, &s->open[i]))
        panels[i].draw(s);
    kd_ui_panel_end(s->ui);
}

void window_draw_panels(window_session *s)
{
    if (s->alarm && !s->open[WINDOW_PANEL_MESSAGES]) {
        s->open[WINDOW_PANEL_MESSAGES] = true; /* also over hidden panels: nobody must miss it */
        s->panels = true;
    }
    if (!s->panels)
        return;
    draw_bar(s);
    for (int i = 0; i < WINDOW_PANEL_COUNT; i++)
        if (s->open[i])
            draw_panel(s, i);
}
