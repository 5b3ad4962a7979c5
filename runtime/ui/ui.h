#ifndef KD_UI_UI_H
#define KD_UI_UI_H

/* Panels over the picture of a window: every frame the caller says anew what they hold, between kd_ui_begin
 * and kd_ui_end. Dear ImGui lays them out; events come from runtime/gpu/window.h, and what is to be drawn
 * goes through runtime/gpu. Labels name a widget inside its panel; what stands after "##" is not shown.
 * Lengths are pixels of a plain monitor: they grow with the window's scale. Threading: the GPU lane, one at a
 * time. */

#ifdef __cplusplus
extern "C" {
#endif

#include "runtime/gpu/window.h"

typedef struct kd_ui kd_ui;

/** Open it for a window. Errors NO_MEMORY, GPU; one message */
kd_status kd_ui_open(kd_gpu *gpu, kd_ui **out);
void kd_ui_close(kd_ui *ui); /* NULL does nothing */

/* ---- events ---- */
/** Take an event in. Returns true when it is the panels' own: a click on one, typing into a field. */
bool kd_ui_event(kd_ui *ui, const kd_window_event *event);
/** Tell whether events wait for another frame: a press and its release never share one. */
bool kd_ui_waiting(const kd_ui *ui);

/* ---- frames ---- */
/** Begin to say what is shown. dt_s: since the last time */
void kd_ui_begin(kd_ui *ui, float dt_s);
/** Draw it over what the window shows. */
void kd_ui_end(kd_ui *ui);
/** Size of the window in the lengths of panels. */
void kd_ui_size(const kd_ui *ui, float *width, float *height);

/* ---- panels and menus ---- */
/** Begin a panel, at first at this place with this size. Its contents are said only when this returns true,
 * and kd_ui_panel_end in any case. open  set to false when it is closed; NULL: it has no cross */
bool kd_ui_panel_begin(kd_ui *ui, const char *title, float x, float y, float width, float height, bool *open);
void kd_ui_panel_end(kd_ui *ui);
/** Begin the bar of menus at the window's top. As panels. */
bool kd_ui_bar_begin(kd_ui *ui);
void kd_ui_bar_end(kd_ui *ui); /* only after true */
bool kd_ui_menu_begin(kd_ui *ui, const char *label);
void kd_ui_menu_end(kd_ui *ui); /* only after true */
/** An entry; `key` is shown beside it or NULL. Returns true when it is chosen. */
bool kd_ui_menu_item(kd_ui *ui, const char *label, const char *key, bool marked);
/** Begin a list with a bar of its own; height 0: what is left of the panel. */
void kd_ui_list_begin(kd_ui *ui, const char *label, float height);
void kd_ui_list_end(kd_ui *ui);

/* ---- what stands in them ---- */
void kd_ui_text(kd_ui *ui, const char *format, ...) __attribute__((format(printf, 2, 3)));
void kd_ui_text_dim(kd_ui *ui, const char *format, ...) __attribute__((format(printf, 2, 3)));
void kd_ui_text_wrapped(kd_ui *ui, const char *text);
void kd_ui_text_error(kd_ui *ui, const char *text); /* wrapped */
void kd_ui_hint(kd_ui *ui, const char *text);       /* shown while the pointer rests on the widget before */
void kd_ui_same_line(kd_ui *ui);
void kd_ui_separator(kd_ui *ui);
/** Widgets until kd_ui_id_end may have labels that stand elsewhere too. */
void kd_ui_id_begin(kd_ui *ui, uint64_t id);
void kd_ui_id_end(kd_ui *ui);
/** Until kd_ui_disabled_end they are grey and do nothing, if so. */
void kd_ui_disabled_begin(kd_ui *ui, bool disabled);
void kd_ui_disabled_end(kd_ui *ui);

/* ---- widgets: true when the value was changed ---- */
bool kd_ui_button(kd_ui *ui, const char *label);
bool kd_ui_check(kd_ui *ui, const char *label, bool *value);
/** Choose one of `count` words. */
bool kd_ui_choose(kd_ui *ui, const char *label, const char *const *words, uint32_t count, uint32_t *index);
/** One to four numbers that are dragged, or typed after Ctrl and a click. min == max: no limits; `whole`:
 * integers; speed: change a pixel */
bool kd_ui_numbers(kd_ui *ui, const char *label, double *values, uint32_t count, double speed, double min,
                   double max, bool whole);
/** A linear colour, shown and chosen as the screen's. */
bool kd_ui_color(kd_ui *ui, const char *label, float rgb[3]);
bool kd_ui_string(kd_ui *ui, const char *label, char *text, size_t size);
/** A line to choose. */
bool kd_ui_line(kd_ui *ui, const char *label, bool chosen);
/** A heading under which things are hidden until it is clicked. */
bool kd_ui_heading(kd_ui *ui, const char *label, bool open_at_first);
/** A node of a tree. Returns true when what is below is to be said, then kd_ui_node_end. chosen  is marked;
 * *clicked  was clicked now */
bool kd_ui_node_begin(kd_ui *ui, uint64_t id, const char *label, bool leaf, bool chosen, bool *clicked);
void kd_ui_node_end(kd_ui *ui);

/* ---- tables and curves ---- */
/** Begin a table: the first column takes what the others, `width` wide each, leave. */
bool kd_ui_table_begin(kd_ui *ui, const char *label, const char *const *columns, uint32_t count, float width,
                       float height);
void kd_ui_table_end(kd_ui *ui); /* only after true */
void kd_ui_cell(kd_ui *ui, const char *format, ...) __attribute__((format(printf, 2, 3))); /* the next one */
/** Begin a row with a line that can be chosen; returns true when it is. */
bool kd_ui_row(kd_ui *ui, const char *label, bool chosen);
/** Draw a curve of values, oldest first, from 0 to `top`. Shapes  values: count, a ring that begins at first
 */
void kd_ui_curve(kd_ui *ui, const char *label, const float *values, uint32_t count, uint32_t first, float top,
                 float height);
/** Draw a bar that is `share` (0 to 1) full, with a text. */
void kd_ui_bar(kd_ui *ui, float share, const char *text);

#ifdef __cplusplus
}
#endif

#endif
