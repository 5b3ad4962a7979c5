/* The tree of entities, and every component of the one that is chosen. */
#include <stdio.h>

#include "runtime/app/window/session.h"

/* A crowd is not listed to its last member: the panel is drawn anew with every picture. */
enum { MAX_LISTED = 2000 };

static const char *kind_of(const kd_world *w, kd_entity e)
{
    static const char *const kinds[] = {"light", "camera", "mesh_instance", "animation"};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        kd_component_id id = kd_component_find(w, kinds[i]);
        if (id && kd_has_id(w, e, id))
            return i == 2 ? "mesh" : kinds[i];
    }
    return "entity";
}

static void draw_node(window_session *s, kd_entity e, uint32_t *listed)
{
    char label[96];
    bool clicked = false;
    const kd_world *w = s->stage->world;
    const char *name = kd_get_name(w, e);
    if (*listed >= MAX_LISTED)
        return;
    ++*listed;
    kd_entity child = kd_first_child(w, e);
    snprintf(label, sizeof label, *name ? "%.60s" : "%s %u", *name ? name : kind_of(w, e), e.index);
    bool open = kd_ui_node_begin(s->ui, (uint64_t)e.generation << 32 | e.index, label, !child.generation,
                                 kd_entity_equal(e, s->chosen), &clicked);
    kd_ui_hint(s->ui, kind_of(w, e));
    if (clicked)
        s->chosen = e;
    if (!open)
        return;
    for (; child.generation; child = kd_next_sibling(w, child))
        draw_node(s, child, listed);
    kd_ui_node_end(s->ui);
}

static void draw_tree(window_session *s)
{
    uint32_t listed = 0;
    const kd_world *w = s->stage->world;
    bool roots = true;
    kd_ui_list_begin(s->ui, "tree", 150);
    for (kd_iter it = kd_query_iter(s->everything); roots && kd_iter_next(&it);) {
        for (uint32_t i = 0; i < it.count && roots && listed < MAX_LISTED; i++) {
            roots = !kd_get_parent(w, it.entities[i]).generation; /* they come first */
            if (roots)
                draw_node(s, it.entities[i], &listed);
        }
        roots = roots && listed < MAX_LISTED;
    }
    if (listed >= MAX_LISTED)
        kd_ui_text_dim(s->ui, "... of %u entities", kd_entity_count(w));
    kd_ui_list_end(s->ui);
}

static void draw_chosen(window_session *s)
{
    kd_world *w = s->stage->world;
    const char *name = kd_get_name(w, s->chosen);
    kd_ui_text(s->ui, "%s %u%s%s", kind_of(w, s->chosen), s->chosen.index, *name ? ": " : "", name);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++)
        if (kd_has_id(w, s->chosen, id))
            window_panel_component(s, s->chosen, id);
}

/* What the world has one of. */
static void draw_world(window_session *s)
{
    kd_world *w = s->stage->world;
    kd_ui_text_dim(s->ui, "what the world has one of:");
    for (kd_component_id id = 1; id <= kd_component_count(w); id++)
        if (kd_component_info(w, id)->field_count && kd_singleton_find(w, id))
            window_panel_component(s, KD_NO_ENTITY, id);
}

void window_panel_scene(window_session *s)
{
    kd_ui_text(s->ui, "%u entities", kd_entity_count(s->stage->world));
    kd_ui_same_line(s->ui);
    kd_ui_check(s->ui, "world", &s->chosen_world);
    kd_ui_hint(s->ui, "show what the world has one of instead of an entity");
    draw_tree(s);
    kd_ui_separator(s->ui);
    kd_ui_list_begin(s->ui, "values", 0);
    if (s->chosen_world)
        draw_world(s);
    else if (kd_alive(s->stage->world, s->chosen))
        draw_chosen(s);
    else
        kd_ui_text_dim(s->ui, "choose an entity");
    kd_ui_list_end(s->ui);
}
