/* What the picture shows and by which technique it is lit. */
#include "runtime/app/window/session.h"

static bool choose(window_session *s, const char *label, const char *const *words, uint32_t *index)
{
    uint32_t count = 0;
    while (words[count])
        count++;
    bool changed = kd_ui_choose(s->ui, label, words, count, index);
    if (changed)
        window_touch(s);
    return changed;
}

void window_panel_view(window_session *s)
{
    choose(s, "technique", app_gi_words, &s->stage->scene.gi);
    choose(s, "view", app_view_words, &s->stage->scene.view);
    kd_ui_hint(
        s->ui,
        "+ and - on the number pad change the level of views that have levels, * and / what they show");
    kd_ui_separator(s->ui);
    window_settings(s, "view");
}
