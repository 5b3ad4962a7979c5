/* The light bar: every lamp of the scene, and what goes for all of them. Source  Yalciner 2016, figure A.2 */
#include <stdio.h>

#include "components/light.h"
#include "components/transform.h"
#include "runtime/app/window/session.h"

static void draw_field(window_session *s, kd_entity e, const char *component, const char *field)
{
    kd_component_id id = kd_component_find(s->stage->world, component);
    if (id && kd_has_id(s->stage->world, e, id))
        window_panel_field(s, e, id, field);
}

static void draw_lamp(window_session *s, kd_entity e, const kd_light *light, uint32_t number)
{
    static const char *const kinds[] = {"directional", "point", "spot"};
    char label[96];
    const char *name = kd_get_name(s->stage->world, e);
    snprintf(label, sizeof label, "%.48s%s%s##lamp", *name ? name : "lamp ", *name ? ", " : "",
             kinds[light->type < 3 ? light->type : 0]);
    kd_ui_id_begin(s->ui, (uint64_t)e.index + 1);
    if (kd_ui_heading(s->ui, label, number < 3)) {
        uint32_t type = light->type;
        draw_field(s, e, "light", "color");
        draw_field(s, e, "light", "intensity");
        if (type != KD_DIRECTIONAL) {
            draw_field(s, e, "transform", "position");
            draw_field(s, e, "light", "range");
        }
        if (type != KD_POINT)
            draw_field(s, e, "transform", "rotation");
        if (type == KD_SPOT) {
            draw_field(s, e, "light", "inner_cone");
            draw_field(s, e, "light", "outer_cone");
        }
        draw_field(s, e, "light", "no_shadow");
    }
    kd_ui_id_end(s->ui);
}

/* Lamps in a fixed list: drawing one may change the world. */
enum { MAX_LAMPS = 64 };

static uint32_t list_lamps(window_session *s, kd_entity *out)
{
    uint32_t count = 0;
    for (kd_iter it = kd_query_iter(s->lamps); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count && count < MAX_LAMPS; i++)
            out[count++] = it.entities[i];
    return count;
}

void window_panel_lights(window_session *s)
{
    kd_entity lamps[MAX_LAMPS];
    kd_world *w = s->stage->world;
    uint32_t count = list_lamps(s, lamps);
    window_history_stats frame = window_history_read(&s->history, s->history.row_count - 1);
    kd_ui_text(s->ui, "%u lamps, frame %.1f ms", count, (double)frame.median_ms);
    for (uint32_t i = 0; i < count; i++) {
        const kd_light *light = kd_find(w, lamps[i], kd_light);
        if (light)
            draw_lamp(s, lamps[i], light, i);
    }
    kd_ui_separator(s->ui);
    window_settings(s, "light");
}
