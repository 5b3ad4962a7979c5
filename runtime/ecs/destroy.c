/* Deaths: of one entity with all below it, of many, of all that a query matches. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/internal.h"

/* ---- one, with its children ---- */
static inline void destroy_one(kd_world *w, kd_entity e, ecs_table *t, uint32_t row)
{
    if (t->depth)
        ecs_hierarchy_unlink(w, e.index, ecs_parents(t)[row].index);
    if (w->any_observed)
        ecs_event_row(w, KD_ON_REMOVE | KD_ON_DESTROY, t, row);
    if (e.index < w->name_limit)
        ecs_name_drop(w, e.index);
    if (w->side_limit)
        ecs_sides_drop(w, e.index);
    if (w->pair_count)
        ecs_relations_drop(w, e);
    if (t->archetype->hooked)
        ecs_table_release_rows(w, t, row, 1);
    ecs_table_remove(w, t, row);
    ecs_handle_give(w, e);
}

/* Leaves first, and without a stack: descend to the first child until there is none, destroy, go back up. */
static void destroy_subtree(kd_world *w, uint32_t root)
{
    uint32_t at = root;
    for (;;) {
        uint32_t child = ecs_first_child(w, at);
        if (child != ECS_NONE) {
            at = child;
            continue;
        }
        ecs_table *t = ecs_table_of(w, at);
        uint32_t row = ecs_row_of(w, at), parent = t->depth ? ecs_parents(t)[row].index : ECS_NONE;
        destroy_one(w, ecs_handle_at(w, at), t, row);
        if (at == root)
            return;
        at = parent;
    }
}

/* Sources that die with a target; the list may grow on the way. */
static void destroy_doomed(kd_world *w)
{
    for (uint32_t i = 0; i < w->doomed_count; i++)
        if (kd_alive(w, w->doomed[i]))
            destroy_subtree(w, w->doomed[i].index);
    w->doomed_count = 0;
}

void kd_destroy(kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_settle(w, &e, &t, &row))
        return;
    ecs_structure_changed(w, "kd_destroy");
    if (ecs_first_child(w, e.index) == ECS_NONE)
        destroy_one(w, e, t, row);
    else
        destroy_subtree(w, e.index);
    if (w->doomed_count)
        destroy_doomed(w);
    ecs_events_settle(w);
}

/* ---- many deaths ---- */
void kd_destroy_n(kd_world *w, const kd_entity *entities, uint32_t n)
{
    w->event_hold++;
    for (uint32_t i = 0; i < n; i++)
        kd_destroy(w, entities[i]);
    w->event_hold--;
    ecs_events_settle(w);
}

/* Nothing but the rows themselves: no children, names, values beside the table, pairs, hooks or observers. */
static bool rows_stand_alone(const kd_world *w, const ecs_table *t)
{
    if (t->depth || t->archetype->hooked || t->archetype->observed || w->side_limit || w->pair_count)
        return false;
    for (uint32_t row = 0; row < t->count && (w->node_limit || w->name_limit); row++) {
        uint32_t index = ecs_entities(t)[row].index;
        if (ecs_first_child(w, index) != ECS_NONE || (index < w->name_limit && w->name_links[index].group))
            return false;
    }
    return true;
}

static void empty_table(kd_world *w, ecs_table *t)
{
    const kd_entity *entities = ecs_entities(t);
    if (rows_stand_alone(w, t)) {
        for (uint32_t row = t->count; row-- > 0;)
            ecs_handle_give(w, entities[row]);
        t->count = 0;
    }
    while (t->count)
        kd_destroy(w, ecs_entities(t)[t->count - 1]);
}

static kd_status destroy_rows(kd_query *q)
{
    kd_world *w = q->world;
    uint32_t count = kd_query_count(q), at = 0;
    kd_entity *list = ecs_grow(w, NULL, 0, count * sizeof *list);
    if (!list)
        return KD_NO_MEMORY;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); at += it.count)
        memcpy(list + at, it.entities, it.count * sizeof *list);
    kd_destroy_n(w, list, count);
    ecs_free(w, list);
    return KD_OK;
}

kd_status kd_destroy_query(kd_query *q)
{
    kd_world *w = q->world;
    if (q->row_terms)
        return destroy_rows(q);
    ecs_structure_changed(w, "kd_destroy_query");
    w->event_hold++;
    for (uint32_t i = 0; i < q->match_count; i++)
        empty_table(w, q->matches[i].table);
    w->event_hold--;
    ecs_events_settle(w);
    return KD_OK;
}
