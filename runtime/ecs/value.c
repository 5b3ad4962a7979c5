/* The values of one entity: finding, setting, removing, hiding. Adding or removing a component moves the row
 * to the neighbouring archetype's table. */

#include <assert.h>

#include "runtime/ecs/internal.h"

/* ---- finding ---- */
const void *ecs_find_slow(const kd_world *w, kd_entity e, kd_component_id id)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return NULL;
    uint32_t column = ecs_column_of(t, id);
    if (!column && ecs_is_sparse(w, id))
        return w->components[id].relation ? ecs_relation_find(w, id, ecs_entities(t)[row])
                                          : ecs_side_find(w, id, ecs_entities(t)[row].index);
    return column ? ecs_value_at(w, t, column, row) : NULL;
}

kd_lookup kd_lookup_make(kd_world *w, const kd_component_desc *desc)
{
    assert(desc->size && !(desc->flags & (KD_COMPONENT_SPARSE | KD_COMPONENT_RELATION)) &&
           "a look-up is for values in tables");
    kd_component_id id = kd_component_ensure(w, desc);
    const ecs_places *p = &w->head.places[id];
    ecs_watch_value(w, id, false);
    return (kd_lookup){.records = w->head.records,
                       .columns = p->columns,
                       .entity_limit = w->head.entity_limit,
                       .table_limit = p->limit,
                       .size = p->size,
                       .world = w,
                       .structure = w->structure};
}

void ecs_lookup_check(const kd_lookup *l)
{
    assert(l->structure == l->world->structure && "the world changed: make the look-up again");
    (void)l;
}

static void *find_mut_beside(kd_world *w, kd_entity e, kd_component_id id)
{
    bool relation = w->components[id].relation;
    void *value = relation ? ecs_relation_find(w, id, e) : ecs_side_find(w, id, e.index);
    if (value && relation)
        ecs_relation_stamp(w, ecs_relation_of(w, id));
    else if (value)
        ecs_side_stamp(w, ecs_side_of(w, id));
    return value;
}

void *kd_find_mut_id(kd_world *w, kd_entity e, kd_component_id id)
{
    ecs_table *t;
    uint32_t row;
#ifndef NDEBUG
    ecs_watch_value(w, id, true);
#endif
    if (!ecs_locate(w, e, &t, &row))
        return NULL;
    uint32_t column = ecs_column_of(t, id);
    if (!column && ecs_is_sparse(w, id))
        return find_mut_beside(w, ecs_entities(t)[row], id);
    if (!column)
        return NULL;
    if (column != ECS_TAG_COLUMN)
        ecs_column_stamp(w, t, column, row, 1);
    return ecs_value_at(w, t, column, row);
}

/* ---- setting and removing ---- */
static kd_status set_sparse(kd_world *w, kd_entity e, kd_component_id id, const void *value)
{
    if (!ecs_needs_no_target(w, id))
        return KD_UNSUPPORTED;
    kd_event event = w->observed[id] && ecs_side_find(w, id, e.index) ? KD_ON_SET : KD_ON_ADD;
    kd_status status = ecs_side_set(w, id, e, value);
    if (!status)
        ecs_event(w, event, e, id, NULL);
    return status;
}

static kd_status replace_value(kd_world *w, kd_entity e, ecs_table *t, uint32_t row, kd_component_id id,
                               const void *value)
{
    uint32_t column = t->column_of[id];
    void *to = ecs_value_at(w, t, column, row);
    ecs_event(w, KD_ON_SET, e, id, NULL);
    if (column == ECS_TAG_COLUMN || to == value)
        return KD_OK;
    ecs_release_value(w, id, to);
    ecs_write_value(w, id, to, value);
    ecs_column_stamp(w, t, column, row, 1);
    return KD_OK;
}

kd_status ecs_set_id(kd_world *w, kd_entity e, kd_component_id id, const void *value)
{
    ecs_table *t;
    uint32_t row;
    if (!id)
        return KD_NO_MEMORY;
    if (!ecs_settle(w, &e, &t, &row))
        return KD_NOT_FOUND;
    if (w->components[id].sparse)
        return set_sparse(w, e, id, value);
    if (ecs_column_of(t, id))
        return replace_value(w, e, t, row, id, value);
    ecs_structure_changed(w, "kd_set");
    ecs_table *to = ecs_neighbour(w, t, id);
    if (!to || !ecs_rows_reserve(w, to, 1, &value, 1))
        return KD_NO_MEMORY;
    uint32_t column = to->column_of[id];
    if (column != ECS_TAG_COLUMN) /* before the row moves: the value may lie in it */
        ecs_write_value(w, id, ecs_value_at(w, to, column, to->count), value);
    ecs_table_move_row(w, t, row, to, e, 0, column);
    ecs_event(w, KD_ON_ADD, e, id, NULL);
    return KD_OK;
}

kd_status kd_set_value(kd_world *w, kd_entity e, kd_value value)
{
    kd_component_id id = kd_component_ensure(w, value.desc);
    if (!id)
        return ecs_component_refusal(w, value.desc);
    kd_status status = ecs_set_id(w, e, id, value.value);
    ecs_events_settle(w);
    return status;
}

static void remove_beside(kd_world *w, kd_entity e, kd_component_id id)
{
    if (w->components[id].relation) {
        ecs_relation_remove(w, id, e);
    } else {
        const void *value = w->observed[id] ? ecs_side_find(w, id, e.index) : NULL;
        if (value)
            ecs_event(w, KD_ON_REMOVE, e, id, w->components[id].size ? value : NULL);
        ecs_side_remove(w, id, e.index);
    }
    ecs_events_settle(w);
}

kd_status kd_remove_id(kd_world *w, kd_entity e, kd_component_id id)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_settle(w, &e, &t, &row))
        return KD_NOT_FOUND;
    if (id > ECS_MAX_COMPONENTS)
        return KD_OK;
    if (w->components[id].sparse) {
        remove_beside(w, e, id);
        return KD_OK;
    }
    uint32_t column = ecs_column_of(t, id);
    if (!column)
        return KD_OK;
    ecs_structure_changed(w, "kd_remove");
    ecs_table *to = ecs_neighbour(w, t, id);
    if (!to || !ecs_rows_reserve(w, to, 1, NULL, 0))
        return KD_NO_MEMORY;
    void *value = ecs_value_at(w, t, column, row);
    ecs_event(w, KD_ON_REMOVE, e, id, column == ECS_TAG_COLUMN ? NULL : value);
    if (w->components[id].side)
        ecs_side_disable(w, id, e.index, false);
    if (t->archetype->hooked)
        ecs_release_value(w, id, value);
    ecs_table_move_row(w, t, row, to, e, column, 0);
    ecs_events_settle(w);
    return KD_OK;
}

/* ---- enable bits ---- */
kd_status kd_enable_id(kd_world *w, kd_entity e, kd_component_id id, bool enabled)
{
    ecs_table *t;
    uint32_t row;
    if (!id)
        return KD_NO_MEMORY;
    if (id > kd_component_count(w)) /* an id of another world */
        return KD_NOT_FOUND;
    if (!(w->components[id].desc->flags & KD_COMPONENT_TOGGLE))
        return kd_fail(KD_UNSUPPORTED, "component %s: has no enable bits; declare it KD_COMPONENT_TOGGLE",
                       w->components[id].desc->name);
    if (!kd_find_id(w, e, id) || !ecs_locate(w, e, &t, &row))
        return KD_NOT_FOUND;
    uint32_t column = ecs_column_of(t, id);
    if (!ecs_side_disable(w, id, ecs_entities(t)[row].index, !enabled))
        return KD_NO_MEMORY;
    if (column && column != ECS_TAG_COLUMN)
        ecs_column_stamp(w, t, column, row, 1);
    return KD_OK;
}

bool kd_is_enabled_id(const kd_world *w, kd_entity e, kd_component_id id)
{
    ecs_table *t;
    uint32_t row;
    return kd_find_id(w, e, id) && ecs_locate(w, e, &t, &row) &&
           !ecs_side_disabled(ecs_side_of(w, id), ecs_entities(t)[row].index);
}
