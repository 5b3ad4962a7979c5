/* What went wrong, newest first. */
#include "runtime/app/window/session.h"

void window_panel_messages(window_session *s)
{
    if (s->message_count == 0)
        kd_ui_text_dim(s->ui, "nothing to tell");
    for (uint32_t i = s->message_count; i-- > 0;) {
        const window_message *m = &s->messages[(s->message_first + i) % WINDOW_MESSAGES];
        if (m->error)
            kd_ui_text_error(s->ui, m->text);
        else
            kd_ui_text_wrapped(s->ui, m->text);
    }
}
