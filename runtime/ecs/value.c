/* The values of one entity: finding, setting, removing, hiding. Adding or removing a component moves the row
 * to the neighbouring archetype's table. */

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
        return ecs_side_find(w, id, ecs_entities(t)[row].index);
    return column ? ecs_value_at(w, t, column, row) : NULL;
}

void *kd_find_mut_id(kd_world *w, kd_entity e, kd_component_id id)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return NULL;
    uint32_t column = ecs_column_of(t, id);
    if (!column && ecs_is_sparse(w, id)) {
        void *value = ecs_side_find(w, id, ecs_entities(t)[row].index);
        if (value)
            ecs_side_stamp(w, ecs_side_of(w, id));
        return value;
    }
    if (!column)
        return NULL;
    if (column != ECS_TAG_COLUMN)
        ecs_column_stamp(w, t, column, row, 1);
    return ecs_value_at(w, t, column, row);
}

/* ---- setting and removing ---- */
static uint32_t move_row(kd_world *w, ecs_table *t, uint32_t row, ecs_table *to)
{
    kd_entity e = ecs_entities(t)[row];
    uint32_t to_row = ecs_table_append(w, to, e, t, row);
    ecs_place(w, e, to, to_row);
    return to_row;
}

static kd_status set_sparse(kd_world *w, kd_entity e, kd_component_id id, const void *value)
{
    kd_event event = ecs_side_find(w, id, e.index) ? KD_ON_SET : KD_ON_ADD;
    kd_status status = ecs_side_set(w, id, e, value);
    if (!status)
        ecs_event(w, event, e, id, NULL);
    return status;
}

kd_status ecs_set_id(kd_world *w, kd_entity e, kd_component_id id, const void *value)
{
    ecs_table *t;
    uint32_t row;
    if (!id)
        return KD_NO_MEMORY;
    if (!ecs_locate(w, e, &t, &row))
        return KD_NOT_FOUND;
    if (w->components[id].sparse)
        return set_sparse(w, ecs_entities(t)[row], id, value);
    uint32_t column = ecs_column_of(t, id);
    if (column) {
        ecs_event(w, KD_ON_SET, ecs_entities(t)[row], id, NULL);
        void *to = ecs_value_at(w, t, column, row);
        if (column == ECS_TAG_COLUMN || to == value)
            return KD_OK;
        ecs_release_value(w, id, to);
        ecs_write_value(w, id, to, value);
        ecs_column_stamp(w, t, column, row, 1);
        return KD_OK;
    }
    ecs_structure_changed(w, "kd_set");
    ecs_archetype *a = ecs_archetype_toggle(w, t->archetype, id);
    ecs_table *to = a ? ecs_table_ensure(w, a, t->depth) : NULL;
    if (!to || !ecs_rows_reserve(w, to, 1, &value, 1))
        return KD_NO_MEMORY;
    uint32_t to_row = move_row(w, t, row, to);
    column = to->column_of[id];
    if (column != ECS_TAG_COLUMN)
        ecs_write_value(w, id, ecs_value_at(w, to, column, to_row),
                        value); /* before the old row goes: value may lie there */
    kd_entity moved = ecs_entities(t)[row];
    ecs_table_remove(w, t, row);
    ecs_event(w, KD_ON_ADD, moved, id, NULL);
    return KD_OK;
}

kd_status kd_set_value(kd_world *w, kd_entity e, kd_value value)
{
    kd_status status = ecs_set_id(w, e, kd_component_ensure(w, value.desc), value.value);
    ecs_events_settle(w);
    return status;
}

kd_status kd_remove_id(kd_world *w, kd_entity e, kd_component_id id)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return KD_NOT_FOUND;
    if (w->components[id].sparse) {
        kd_entity known = ecs_entities(t)[row];
        const void *value = ecs_side_find(w, id, known.index);
        if (value)
            ecs_event(w, KD_ON_REMOVE, known, id, w->components[id].size ? value : NULL);
        ecs_side_remove(w, id, known.index);
        ecs_events_settle(w);
        return KD_OK;
    }
    if (!ecs_column_of(t, id))
        return KD_OK;
    ecs_structure_changed(w, "kd_remove");
    ecs_archetype *a = ecs_archetype_toggle(w, t->archetype, id);
    ecs_table *to = a ? ecs_table_ensure(w, a, t->depth) : NULL;
    if (!to || !ecs_table_reserve(w, to, to->count + 1))
        return KD_NO_MEMORY;
    ecs_event(w, KD_ON_REMOVE, ecs_entities(t)[row], id,
              ecs_column_of(t, id) == ECS_TAG_COLUMN ? NULL : ecs_value_at(w, t, ecs_column_of(t, id), row));
    ecs_side_disable(w, id, ecs_entities(t)[row].index, false);
    ecs_release_value(w, id, ecs_value_at(w, t, ecs_column_of(t, id), row));
    move_row(w, t, row, to);
    ecs_table_remove(w, t, row);
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
