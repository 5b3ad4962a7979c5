/* The cone bar. Source  Yalciner 2016, figure A.4 */
#include "runtime/app/window/session.h"

void window_panel_cones(window_session *s)
{
    kd_ui_disabled_begin(s->ui, s->stage->scene.gi == KD_GI_NONE);
    window_settings(s, "cones");
    kd_ui_separator(s->ui);
    kd_ui_text_dim(s->ui, "ambient occlusion");
    window_settings(s, "ao");
    kd_ui_separator(s->ui);
    kd_ui_text_dim(s->ui, "reflections");
    window_settings(s, "specular");
    kd_ui_disabled_end(s->ui);
}
