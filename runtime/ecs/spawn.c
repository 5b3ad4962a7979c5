/* Making entities. A spawn finds its table through archetype edges, or at once on a path that was walked
 * before, reserves everything, and then writes every value once: from there on nothing can fail. */

#include <assert.h>

#include "runtime/ecs/internal.h"

/* ---- room ---- */
bool ecs_rows_grow(kd_world *w, ecs_table *t, uint32_t rows, const void **values, uint32_t count)
{
    uint32_t columns[ECS_MAX_COMPONENTS];
    size_t offsets[ECS_MAX_COMPONENTS];
    for (uint32_t i = 0; i < count; i++) {
        columns[i] = ECS_NONE;
        for (uint32_t c = 0; values[i] && c < t->column_count; c++) {
            uintptr_t base = (uintptr_t)t->columns[c].data, at = (uintptr_t)values[i];
            if (base && at >= base && at - base < (size_t)t->count * t->columns[c].size) {
                columns[i] = c;
                offsets[i] = at - base;
            }
        }
    }
    bool done = ecs_table_reserve(w, t, rows);
    for (uint32_t i = 0; i < count; i++)
        if (columns[i] != ECS_NONE)
            values[i] = t->columns[columns[i]].data + offsets[i];
    return done;
}

static ecs_table *table_of_ids(kd_world *w, const kd_component_id *ids, uint32_t count, uint32_t depth)
{
    ecs_archetype *a = w->archetypes[0];
    for (uint32_t i = 0; i < count && a; i++)
        if (!w->components[ids[i]].sparse && (ids[i] >= a->column_limit || !a->column_of[ids[i]]))
            a = ecs_archetype_toggle(w, a, ids[i]);
    return a ? ecs_table_ensure(w, a, depth) : NULL;
}

/* Does component i stand among those before it? The last value counts; what an earlier one owns is released.
 */
static bool is_repeated(const kd_component_id *ids, uint32_t i)
{
    for (uint32_t k = 0; k < i; k++)
        if (ids[k] == ids[i])
            return true;
    return false;
}

static void write_row(kd_world *w, ecs_table *t, uint32_t row, const kd_component_id *ids,
                      const void **values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t column = ecs_column_of(t, ids[i]);
        if (!column || column == ECS_TAG_COLUMN)
            continue;
        void *to = t->columns[column].data + (size_t)row * t->columns[column].size;
        if (t->archetype->hooked && is_repeated(ids, i))
            ecs_release_value(w, ids[i], to);
        ecs_write_value(w, ids[i], to, values[i]);
    }
}

/* Room beside the tables for the n entities that will be made next; values that lie there follow. */
static bool sparse_reserve_one(kd_world *w, kd_component_id id, uint32_t n)
{
    uint32_t index = w->free_first;
    for (uint32_t k = 0; k < n; k++) {
        bool reuse = k < w->free_count;
        if (!ecs_side_reserve(w, id, reuse ? index : w->head.entity_limit + (k - w->free_count), n))
            return false;
        if (reuse)
            index = ecs_record_row(w->head.records[index]);
    }
    return true;
}

static bool sparse_reserve(kd_world *w, uint32_t n, const kd_component_id *ids, const void **values,
                           uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const ecs_side *s = w->components[ids[i]].sparse ? ecs_side_ensure(w, ids[i]) : NULL;
        uintptr_t base = s ? (uintptr_t)s->values : 0;
        size_t bytes = s ? (size_t)s->count * w->components[ids[i]].size : 0;
        if (!w->components[ids[i]].sparse)
            continue;
        bool done = s && sparse_reserve_one(w, ids[i], n);
        for (uint32_t v = 0; v < count && base; v++)
            if (values[v] && (uintptr_t)values[v] >= base && (uintptr_t)values[v] - base < bytes)
                values[v] = ecs_side_of(w, ids[i])->values + ((uintptr_t)values[v] - base);
        if (!done)
            return false;
    }
    return true;
}

static void sparse_write(kd_world *w, kd_entity e, const kd_component_id *ids, const void **values,
                         uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (w->components[ids[i]].sparse)
            ecs_side_set(w, ids[i], e, values[i]);
}

/* Nodes for a parent and for the entity that will be made next. */
static bool child_nodes_reserve(kd_world *w, uint32_t parent)
{
    uint32_t next = w->free_count ? w->free_first : w->head.entity_limit;
    return ecs_hierarchy_reserve(w, next > parent ? next : parent);
}

static void child_link(kd_world *w, kd_entity e, kd_entity parent)
{
    ecs_parents(ecs_table_of(w, e.index))[ecs_row_of(w, e.index)] = parent;
    ecs_hierarchy_link(w, e.index, parent.index);
}

static kd_entity spawn_ids_at(kd_world *w, const kd_component_id *ids, const void **values, uint32_t count,
                              uint32_t depth)
{
    ecs_table *t = table_of_ids(w, ids, count, depth);
    if (!t || !ecs_handles_reserve(w, 1) || !ecs_rows_reserve(w, t, 1, values, count) ||
        (w->head.sparse_count && !sparse_reserve(w, 1, ids, values, count)))
        return KD_NO_ENTITY;
    kd_entity e = ecs_handle_take(w);
    uint32_t row = ecs_table_append(w, t, e);
    write_row(w, t, row, ids, values, count);
    if (w->head.sparse_count)
        sparse_write(w, e, ids, values, count);
    if (w->any_observed)
        ecs_event_row(w, KD_ON_ADD, t, row);
    return e;
}

kd_entity ecs_spawn_ids(kd_world *w, const kd_component_id *ids, const void **values, uint32_t count)
{
    return spawn_ids_at(w, ids, values, count, 0);
}

static kd_entity spawn_child_ids(kd_world *w, kd_entity parent, const kd_component_id *ids,
                                 const void **values, uint32_t count)
{
    kd_entity e = KD_NO_ENTITY;
    if (child_nodes_reserve(w, parent.index))
        e = spawn_ids_at(w, ids, values, count, kd_get_depth(w, parent) + 1);
    if (e.generation)
        child_link(w, e, parent);
    return e;
}

/* Ids of the values' components, 0 and a message when one cannot be had. */
static bool ids_of(kd_world *w, const kd_value *values, uint32_t count, kd_component_id *ids,
                   const void **from)
{
    assert(count <= ECS_MAX_COMPONENTS);
    for (uint32_t i = 0; i < count; i++) {
        ids[i] = kd_component_ensure(w, values[i].desc);
        from[i] = values[i].value;
        if (!ids[i] || !ecs_needs_no_target(w, ids[i]))
            return false;
    }
    return true;
}

/* The general case: any number of values. */
static kd_entity spawn_many(kd_world *w, kd_entity parent, const kd_value *values, uint32_t count)
{
    kd_component_id ids[ECS_MAX_COMPONENTS];
    const void *from[ECS_MAX_COMPONENTS];
    if (!ids_of(w, values, count, ids, from))
        return KD_NO_ENTITY;
    return parent.generation ? spawn_child_ids(w, parent, ids, from, count)
                             : ecs_spawn_ids(w, ids, from, count);
}

static bool path_leads(const ecs_path *p, const kd_value *values, uint32_t count, uint32_t depth)
{
    if (!p->table || p->count != count || p->depth != depth)
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (p->descs[i] != values[i].desc)
            return false;
    return true;
}

static ecs_path *path_make(kd_world *w, ecs_path *p, const kd_value *values, uint32_t count, uint32_t depth)
{
    const void *from[ECS_PATH_VALUES];
    *p = (ecs_path){.count = count, .depth = depth};
    ecs_table *t = ids_of(w, values, count, p->ids, from) ? table_of_ids(w, p->ids, count, depth) : NULL;
    for (uint32_t i = 0; i < count && t; i++) {
        p->descs[i] = values[i].desc;
        p->columns[i] = (uint16_t)ecs_column_of(t, p->ids[i]);
        p->sparse |= !p->columns[i];
        p->repeats |= t->archetype->hooked && is_repeated(p->ids, i);
    }
    p->table = t;
    return t ? p : NULL;
}

/* The path of these values at this depth; count is at most ECS_PATH_VALUES. Returns NULL when memory is out.
 */
static ecs_path *path_ensure(kd_world *w, const kd_value *values, uint32_t count, uint32_t depth)
{
    uint64_t hash = depth;
    for (uint32_t i = 0; i < count; i++)
        hash = (hash ^ (uint64_t)(uintptr_t)values[i].desc) * 0x9e3779b97f4a7c15u;
    ecs_path *p = &w->paths[hash >> 58];
    return path_leads(p, values, count, depth) ? p : path_make(w, p, values, count, depth);
}

static kd_entity spawn_on_path(kd_world *w, const ecs_path *p, const kd_value *values)
{
    const void *from[ECS_PATH_VALUES];
    ecs_table *t = p->table;
    for (uint32_t i = 0; i < p->count; i++)
        from[i] = values[i].value;
    if (!ecs_handles_reserve(w, 1) || !ecs_rows_reserve(w, t, 1, from, p->count) ||
        (p->sparse && !sparse_reserve(w, 1, p->ids, from, p->count)))
        return KD_NO_ENTITY;
    kd_entity e = ecs_handle_take(w);
    uint32_t row = ecs_table_append(w, t, e);
    for (uint32_t i = 0; i < p->count; i++) {
        if (p->columns[i] - 1u >= ECS_TAG_COLUMN - 1)
            continue; /* a tag, or beside the table */
        const ecs_column *column = &t->columns[p->columns[i]];
        void *to = column->data + (size_t)row * column->size;
        if (p->repeats && is_repeated(p->ids, i))
            ecs_release_value(w, p->ids[i], to);
        if (from[i])
            ecs_copy(to, from[i], column->size);
        else
            ecs_write_value(w, p->ids[i], to, NULL);
    }
    if (p->sparse)
        sparse_write(w, e, p->ids, from, p->count);
    if (w->any_observed)
        ecs_event_row(w, KD_ON_ADD, t, row);
    return e;
}

kd_entity kd_spawn_values(kd_world *w, const kd_value *values, uint32_t count)
{
    ecs_structure_changed(w, "kd_spawn");
    const ecs_path *p = count <= ECS_PATH_VALUES ? path_ensure(w, values, count, 0) : NULL;
    kd_entity e = count > ECS_PATH_VALUES ? spawn_many(w, KD_NO_ENTITY, values, count)
                  : p                     ? spawn_on_path(w, p, values)
                                          : KD_NO_ENTITY;
    ecs_events_settle(w);
    return e;
}

kd_entity kd_spawn_child_values(kd_world *w, kd_entity parent, const kd_value *values, uint32_t count)
{
    ecs_table *above;
    uint32_t row;
    if (!ecs_locate(w, parent, &above, &row) || above->depth == ECS_MAX_DEPTH)
        return KD_NO_ENTITY;
    parent = ecs_entities(above)[row];
    ecs_structure_changed(w, "kd_spawn_child");
    if (count > ECS_PATH_VALUES) {
        kd_entity e = spawn_many(w, parent, values, count);
        ecs_events_settle(w);
        return e;
    }
    const ecs_path *p = path_ensure(w, values, count, above->depth + 1u);
    if (!p || !child_nodes_reserve(w, parent.index))
        return KD_NO_ENTITY;
    kd_entity e = spawn_on_path(w, p, values);
    if (e.generation)
        child_link(w, e, parent);
    ecs_events_settle(w);
    return e;
}

static void fill_column(kd_world *w, kd_component_id id, ecs_column *column, uint32_t row, uint32_t n,
                        const void *values, bool repeated)
{
    uint8_t *to = column->data + (size_t)row * column->size;
    for (uint32_t i = 0; i < n && repeated; i++)
        ecs_release_value(w, id, to + (size_t)i * column->size);
    if (values)
        memmove(to, values, (size_t)n * column->size);
    else
        for (uint32_t i = 0; i < n; i++)
            ecs_write_value(w, id, to + (size_t)i * column->size, NULL);
}

static void fill_sparse(kd_world *w, kd_component_id id, const kd_entity *e, uint32_t n, const void *values)
{
    bool twice = ecs_side_find(w, id, e[0].index); /* the component was given twice: the last value counts */
    for (uint32_t i = 0; i < n; i++) {
        const void *value = values ? (const uint8_t *)values + (size_t)i * w->components[id].size : NULL;
        if (twice)
            ecs_side_set(w, id, e[i], value);
        else
            ecs_side_add(w, id, e[i], value);
    }
}

kd_status kd_spawn_n(kd_world *w, uint32_t n, const kd_component_desc *const *descs,
                     const void *const *columns, uint32_t component_count, kd_entity *out)
{
    kd_component_id ids[ECS_MAX_COMPONENTS];
    const void *from[ECS_MAX_COMPONENTS];
    assert(component_count <= ECS_MAX_COMPONENTS);
    ecs_structure_changed(w, "kd_spawn_n");
    for (uint32_t i = 0; i < component_count; i++) {
        ids[i] = kd_component_ensure(w, descs[i]);
        from[i] = columns ? columns[i] : NULL;
        if (!ids[i])
            return ecs_component_refusal(w, descs[i]);
        if (!ecs_needs_no_target(w, ids[i]))
            return KD_UNSUPPORTED;
    }
    ecs_table *t = table_of_ids(w, ids, component_count, 0);
    if (!t || !ecs_handles_reserve(w, n) || !ecs_rows_reserve(w, t, n, from, component_count) ||
        (w->head.sparse_count && !sparse_reserve(w, n, ids, from, component_count)))
        return KD_NO_MEMORY;
    if (!n)
        return KD_OK;
    uint32_t first = t->count;
    t->count += n;
    kd_entity *entities = ecs_entities(t);
    for (uint32_t row = first; row < first + n; row++) {
        entities[row] = ecs_handle_take(w);
        ecs_place(w, entities[row], t, row);
    }
    ecs_table_stamp(w, t, first, n);
    for (uint32_t i = 0; i < component_count; i++)
        if (ecs_column_of(t, ids[i]) - 1u < ECS_TAG_COLUMN - 1)
            fill_column(w, ids[i], &t->columns[t->column_of[ids[i]]], first, n, from[i],
                        t->archetype->hooked && is_repeated(ids, i));
        else if (w->components[ids[i]].sparse)
            fill_sparse(w, ids[i], entities + first, n, from[i]);
    if (out)
        memcpy(out, entities + first, n * sizeof *out);
    for (uint32_t row = first; row < first + n && w->any_observed; row++)
        ecs_event_row(w, KD_ON_ADD, t, row);
    ecs_events_settle(w);
    return KD_OK;
}
