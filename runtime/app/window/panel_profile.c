/* Where the time of the latest frames went: a curve of the frame and of one system, and a table of all. */
#include <stdio.h>

#include "runtime/app/window/session.h"

static const char *const columns[] = {"system", "median", "p95", "max", "share"};

static void draw_curve(window_session *s, uint32_t row, const char *name)
{
    char label[96];
    window_history_stats stats = window_history_read(&s->history, row);
    const window_history *h = &s->history;
    snprintf(label, sizeof label, "%s: %.2f ms, at most %.2f", name, (double)stats.median_ms,
             (double)stats.max_ms);
    kd_ui_id_begin(s->ui, row);
    kd_ui_curve(s->ui, label, h->rows[row].ms, h->count, h->count < WINDOW_HISTORY_FRAMES ? 0 : h->first,
                stats.max_ms > 0 ? stats.max_ms : 1, 44);
    kd_ui_id_end(s->ui);
}

static void draw_row(window_session *s, const kd_profile *profile, uint32_t row, float whole_ms)
{
    char label[96];
    kd_profile_system system = kd_profile_system_at(profile, row);
    window_history_stats stats = window_history_read(&s->history, row);
    if (stats.max_ms <= 0)
        return;
    snprintf(label, sizeof label, "%s%s", system.name, system.gpu ? " *" : "");
    if (kd_ui_row(s->ui, label, row == s->profile_row))
        s->profile_row = row;
    kd_ui_hint(s->ui, system.phase);
    kd_ui_cell(s->ui, "%.2f", (double)stats.median_ms);
    kd_ui_cell(s->ui, "%.2f", (double)stats.p95_ms);
    kd_ui_cell(s->ui, "%.2f", (double)stats.max_ms);
    kd_ui_cell(s->ui, "%.0f %%", whole_ms > 0 ? 100 * (double)(stats.median_ms / whole_ms) : 0);
}

void window_panel_profile(window_session *s)
{
    const kd_profile *profile = s->stage->timing.profile;
    uint32_t rows = kd_profile_system_count(profile);
    float whole_ms = window_history_read(&s->history, rows).median_ms;
    draw_curve(s, rows, "frame");
    draw_curve(s, s->profile_row, kd_profile_system_at(profile, s->profile_row).name);
    kd_ui_text_dim(s->ui, "ms of the latest %u frames; * on the GPU; click a line for its curve",
                   s->history.count);
    if (!kd_ui_table_begin(s->ui, "systems", columns, 5, 46, 0))
        return;
    for (uint32_t i = 0; i < rows; i++)
        draw_row(s, profile, i, whole_ms);
    kd_ui_table_end(s->ui);
}
