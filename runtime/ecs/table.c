/* Tables: the entities of one archetype at one depth of the hierarchy, struct of arrays. One table a depth,
 * so that visiting tables by depth visits parents before children. */

#include "runtime/ecs/internal.h"

static ecs_table *table_alloc(kd_world *w, ecs_archetype *a, uint32_t depth)
{
    uint32_t columns = a->column_count + (depth ? 2 : 1);
    size_t bytes = sizeof(ecs_table) + (columns + 2u) * sizeof(ecs_column);
    ecs_table *t = ecs_grow(w, NULL, 0, bytes);
    if (!t)
        return NULL;
    memset(t, 0, bytes);
    t->archetype = a;
    t->column_of = a->column_of;
    t->column_limit = a->column_limit;
    t->depth = (uint16_t)depth;
    t->column_count = (uint16_t)columns;
    t->parents = (uint16_t)(depth ? columns - 1 : columns);
    t->index = w->head.table_count;
    t->columns[0].size = t->columns[columns - 1].size = sizeof(kd_entity);
    t->columns[columns + 1u].data = (uint8_t *)w->tag_value;
    for (uint32_t i = 0, c = 1; i < a->id_count; i++) {
        uint32_t size = w->components[a->ids[i]].size;
        if (size) {
            t->columns[c].size = size;
            t->columns[c++].id = a->ids[i];
        }
    }
    return t;
}

static void table_free(kd_world *w, ecs_table *t)
{
    for (uint32_t c = 0; c < t->column_count; c++)
        ecs_free(w, t->columns[c].data);
    ecs_free(w, t->versions);
    ecs_free(w, t);
}

static bool depths_reserve(kd_world *w, ecs_archetype *a, uint32_t depth)
{
    uint32_t limit = a->depth_limit;
    if (!ecs_reserve(w, &a->tables, &a->depth_limit, limit, depth + 1, sizeof(ecs_table *)))
        return false;
    for (uint32_t d = limit; d < a->depth_limit; d++)
        a->tables[d] = NULL;
    return true;
}

/* ---- where values lie ---- */
static bool places_reserve(kd_world *w, const ecs_table *t)
{
    for (uint32_t c = 1; c < t->column_count; c++) {
        ecs_places *p = &w->head.places[t->columns[c].id];
        uint32_t limit = p->limit;
        if (!t->columns[c].id || t->index < limit)
            continue;
        if (!ecs_reserve(w, &p->columns, &p->limit, limit, t->index + 1, sizeof *p->columns))
            return false;
        p->size = t->columns[c].size;
        memset(p->columns + limit, 0, (p->limit - limit) * sizeof *p->columns);
    }
    return true;
}

void ecs_table_note_places(kd_world *w, const ecs_table *t)
{
    for (uint32_t c = 1; c < t->column_count; c++)
        if (t->columns[c].id)
            w->head.places[t->columns[c].id].columns[t->index] = t->columns[c].data;
}

static void places_fini(kd_world *w)
{
    for (uint32_t id = 1; id <= kd_component_count(w) && w->head.places; id++)
        if (w->head.places[id].columns)
            ecs_free(w, w->head.places[id].columns);
    ecs_free(w, w->head.places);
}

/* ---- making ---- */
ecs_table *ecs_table_ensure(kd_world *w, ecs_archetype *a, uint32_t depth)
{
    if (depth < a->depth_limit && a->tables[depth])
        return a->tables[depth];
    if (w->head.table_count == ECS_MAX_TABLES || !depths_reserve(w, a, depth) ||
        !ecs_reserve(w, &w->head.tables, &w->table_capacity, w->head.table_count, w->head.table_count + 1,
                     sizeof(ecs_table *)))
        return NULL;
    ecs_table *t = table_alloc(w, a, depth);
    if (!t)
        return NULL;
    if (!places_reserve(w, t) || !ecs_queries_add_table(w, t)) {
        table_free(w, t);
        return NULL;
    }
    w->head.tables[w->head.table_count++] = t;
    a->tables[depth] = t;
    return t;
}

ecs_table *ecs_neighbour_ensure(kd_world *w, const ecs_table *t, kd_component_id id)
{
    ecs_archetype *a = ecs_archetype_toggle(w, t->archetype, id);
    return a ? ecs_table_ensure(w, a, t->depth) : NULL;
}

static bool versions_reserve(kd_world *w, ecs_table *t, uint32_t capacity)
{
    uint32_t chunks = (capacity + ECS_CHUNK_ROWS - 1) / ECS_CHUNK_ROWS, old = t->chunk_capacity;
    if (chunks <= old)
        return true;
    chunks = chunks > 1 && chunks < old * 2 ? old * 2 : chunks;
    size_t words = (size_t)chunks + 1;
    uint64_t *versions = ecs_grow(w, NULL, 0, words * t->column_count * sizeof *versions);
    if (!versions)
        return false;
    memset(versions, 0, words * t->column_count * sizeof *versions);
    for (uint32_t c = 0; c < t->column_count && old; c++)
        memcpy(&versions[c * words], ecs_versions(t, c), (old + 1) * sizeof *versions);
    ecs_free(w, t->versions);
    t->versions = versions;
    t->chunk_capacity = chunks;
    return true;
}

bool ecs_table_reserve(kd_world *w, ecs_table *t, uint32_t rows)
{
    if (rows <= t->capacity)
        return true;
    uint32_t capacity = ecs_next_capacity(t->capacity, rows);
    if (rows > ECS_ROW_MASK)
        return false;
    if (!versions_reserve(w, t, capacity))
        return false;
    bool done = true;
    for (uint32_t c = 0; c < t->column_count && done; c++) {
        ecs_column *column = &t->columns[c];
        uint8_t *data =
            ecs_grow(w, column->data, (size_t)t->count * column->size, (size_t)capacity * column->size);
        done = data != NULL;
        column->data = done ? data : column->data;
    }
    ecs_table_note_places(w, t); /* also when memory ran out half-way: some have moved */
    if (done)
        t->capacity = capacity;
    return done;
}

void ecs_tables_fini(kd_world *w)
{
    for (uint32_t i = 0; i < w->head.table_count; i++) {
        ecs_table_release_rows(w, w->head.tables[i], 0, w->head.tables[i]->count);
        table_free(w, w->head.tables[i]);
    }
    for (uint32_t i = 0; i < w->archetype_count; i++)
        ecs_archetype_free(w, w->archetypes[i]);
    ecs_free(w, w->head.tables);
    ecs_free(w, w->archetypes);
    ecs_free(w, w->archetype_slots);
    places_fini(w);
}
