/* Archetypes and tables. An archetype is a set of components; its tables hold the entities that have exactly
 * this set, one table for each depth of the hierarchy, so that visiting tables by depth visits parents before
 * children. Archetypes are found through cached edges: one array by component id says where adding (or, if
 * here, removing) it leads. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/internal.h"

/* ---- archetypes ---- */
static uint64_t hash_ids(const kd_component_id *ids, uint32_t count)
{
    return XXH3_64bits(ids, count * sizeof *ids);
}

static bool slots_grow(kd_world *w)
{
    uint32_t count = w->archetype_slot_count ? w->archetype_slot_count * 2 : 64;
    uint32_t *slots = ecs_grow(w, NULL, 0, count * sizeof *slots);
    if (!slots)
        return false;
    memset(slots, 0, count * sizeof *slots);
    for (uint32_t i = 0; i < w->archetype_count; i++) {
        uint32_t s = (uint32_t)w->archetypes[i]->hash & (count - 1);
        while (slots[s])
            s = (s + 1) & (count - 1);
        slots[s] = i + 1;
    }
    ecs_free(w, w->archetype_slots);
    w->archetype_slots = slots;
    w->archetype_slot_count = count;
    return true;
}

static ecs_archetype *archetype_find(const kd_world *w, const kd_component_id *ids, uint32_t count,
                                     uint64_t hash)
{
    if (!w->archetype_slot_count)
        return NULL;
    uint32_t mask = w->archetype_slot_count - 1;
    for (uint32_t s = (uint32_t)hash & mask; w->archetype_slots[s]; s = (s + 1) & mask) {
        ecs_archetype *a = w->archetypes[w->archetype_slots[s] - 1];
        if (a->hash == hash && a->id_count == count &&
            (!count || memcmp(a->ids, ids, count * sizeof *ids) == 0))
            return a;
    }
    return NULL;
}

static void archetype_free(kd_world *w, ecs_archetype *a)
{
    if (!a)
        return;
    ecs_free(w, a->ids);
    ecs_free(w, a->column_of);
    ecs_free(w, a->edges);
    ecs_free(w, a->tables);
    ecs_free(w, a);
}

static ecs_archetype *archetype_alloc(kd_world *w, const kd_component_id *ids, uint32_t count)
{
    ecs_archetype *a = ecs_grow(w, NULL, 0, sizeof *a);
    if (!a)
        return NULL;
    *a = (ecs_archetype){.id_count = count, .column_limit = count ? ids[count - 1] + 1 : 0};
    a->ids = ecs_grow(w, NULL, 0, (count + 1) * sizeof *ids);
    a->column_of = ecs_grow(w, NULL, 0, (a->column_limit + 1) * sizeof *a->column_of);
    if (!a->ids || !a->column_of) {
        archetype_free(w, a);
        return NULL;
    }
    if (count)
        memcpy(a->ids, ids, count * sizeof *ids);
    memset(a->column_of, 0, (a->column_limit + 1) * sizeof *a->column_of);
    for (uint32_t i = 0; i < count; i++) {
        const ecs_component *c = &w->components[ids[i]];
        a->column_of[ids[i]] = c->size ? (uint16_t)++a->column_count : (uint16_t)ECS_TAG_COLUMN;
        a->hooked |= c->desc->on_remove != NULL;
    }
    ecs_archetype_observe(w, a);
    return a;
}

static ecs_archetype *archetype_ensure(kd_world *w, const kd_component_id *ids, uint32_t count)
{
    uint64_t hash = hash_ids(ids, count);
    ecs_archetype *a = archetype_find(w, ids, count, hash);
    if (a)
        return a;
    if (w->archetype_count * 2 >= w->archetype_slot_count && !slots_grow(w))
        return NULL;
    if (!ecs_reserve(w, &w->archetypes, &w->archetype_capacity, w->archetype_count, w->archetype_count + 1,
                     sizeof a))
        return NULL;
    a = archetype_alloc(w, ids, count);
    if (!a)
        return NULL;
    a->hash = hash;
    a->index = w->archetype_count;
    uint32_t s = (uint32_t)hash & (w->archetype_slot_count - 1);
    while (w->archetype_slots[s])
        s = (s + 1) & (w->archetype_slot_count - 1);
    w->archetype_slots[s] = a->index + 1;
    w->archetypes[w->archetype_count++] = a;
    return a;
}

static bool edges_reserve(kd_world *w, ecs_archetype *a, kd_component_id id)
{
    if (id < a->edge_limit)
        return true;
    uint32_t limit = (kd_component_count(w) + 16) & ~15u;
    uint32_t *edges = ecs_grow(w, a->edges, a->edge_limit * sizeof *edges, limit * sizeof *edges);
    if (!edges)
        return false;
    for (uint32_t i = a->edge_limit; i < limit; i++)
        edges[i] = ECS_NONE;
    a->edges = edges;
    a->edge_limit = limit;
    return true;
}

/* The archetype with `id` added, or removed if it is here; a NULL `a` stands for "the empty set itself". */
ecs_archetype *ecs_archetype_toggle(kd_world *w, ecs_archetype *a, kd_component_id id)
{
    if (!a)
        return archetype_ensure(w, NULL, 0);
    if (id < a->edge_limit && a->edges[id] != ECS_NONE)
        return w->archetypes[a->edges[id]];
    kd_component_id ids[ECS_MAX_COMPONENTS + 1];
    uint32_t count = 0;
    bool here = false;
    for (uint32_t i = 0; i < a->id_count; i++) {
        if (!here && a->ids[i] >= id) {
            here = true;
            if (a->ids[i] == id)
                continue;
            ids[count++] = id;
        }
        ids[count++] = a->ids[i];
    }
    if (!here)
        ids[count++] = id;
    ecs_archetype *other = archetype_ensure(w, ids, count);
    if (!other || !edges_reserve(w, a, id) || !edges_reserve(w, other, id))
        return NULL;
    a->edges[id] = other->index;
    other->edges[id] = a->index;
    return other;
}

/* ---- tables ---- */
static ecs_table *table_alloc(kd_world *w, ecs_archetype *a, uint32_t depth)
{
    uint32_t columns = a->column_count + (depth ? 2 : 1);
    size_t bytes = sizeof(ecs_table) + columns * sizeof(ecs_column);
    ecs_table *t = ecs_grow(w, NULL, 0, bytes);
    if (!t)
        return NULL;
    memset(t, 0, bytes);
    t->archetype = a;
    t->column_of = a->column_of;
    t->column_limit = a->column_limit;
    t->depth = (uint16_t)depth;
    t->stamped_chunk = ECS_NONE;
    t->column_count = (uint16_t)columns;
    t->index = w->head.table_count;
    t->columns[0].size = t->columns[columns - 1].size = sizeof(kd_entity);
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

ecs_table *ecs_table_ensure(kd_world *w, ecs_archetype *a, uint32_t depth)
{
    if (depth < a->depth_limit && a->tables[depth])
        return a->tables[depth];
    if (w->head.table_count == ECS_TABLE_MASK || !depths_reserve(w, a, depth) ||
        !ecs_reserve(w, &w->head.tables, &w->table_capacity, w->head.table_count, w->head.table_count + 1,
                     sizeof(ecs_table *)))
        return NULL;
    ecs_table *t = table_alloc(w, a, depth);
    if (!t)
        return NULL;
    if (!ecs_queries_add_table(w, t)) {
        table_free(w, t);
        return NULL;
    }
    w->head.tables[w->head.table_count++] = t;
    a->tables[depth] = t;
    return t;
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
    for (uint32_t c = 0; c < t->column_count; c++) {
        ecs_column *column = &t->columns[c];
        uint8_t *data =
            ecs_grow(w, column->data, (size_t)t->count * column->size, (size_t)capacity * column->size);
        if (!data)
            return false;
        column->data = data;
    }
    t->capacity = capacity;
    return true;
}

/* ---- change versions ---- */
/* Raise, never lower: two threads may stamp one word, and most of the time it holds the value already. */
static inline void raise_version(uint64_t *word, uint64_t version)
{
    uint64_t old = __atomic_load_n(word, __ATOMIC_RELAXED);
    while (old < version &&
           !__atomic_compare_exchange_n(word, &old, version, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
}

void ecs_column_stamp(kd_world *w, ecs_table *t, uint32_t column, uint32_t row, uint32_t count)
{
    uint64_t version = atomic_load_explicit(&w->version, memory_order_relaxed),
             *words = ecs_versions(t, column);
    raise_version(&words[0], version);
    for (uint32_t i = row / ECS_CHUNK_ROWS; i <= (row + count - 1) / ECS_CHUNK_ROWS; i++)
        raise_version(&words[1 + i], version);
}

void ecs_table_stamp(kd_world *w, ecs_table *t, uint32_t row, uint32_t count)
{
    for (uint32_t c = 0; c < t->column_count; c++)
        ecs_column_stamp(w, t, c, row, count);
}

/* One row came or moved. Rows come one after another, so most of the time its chunk bears this version
 * already. */
static inline void stamp_row(kd_world *w, ecs_table *t, uint32_t row)
{
    uint64_t version = atomic_load_explicit(&w->version, memory_order_relaxed);
    uint32_t chunk = row / ECS_CHUNK_ROWS;
    if (t->stamped_version == version && t->stamped_chunk == chunk)
        return;
    ecs_table_stamp(w, t, row, 1);
    t->stamped_version = version;
    t->stamped_chunk = chunk;
}

/* ---- rows ---- */
static inline void copy_row(const ecs_column *to, uint32_t to_row, const ecs_column *from, uint32_t from_row)
{
    ecs_copy(to->data + (size_t)to_row * to->size, from->data + (size_t)from_row * from->size, to->size);
}

/* Copy what two tables have in common. Both lists ascend, and mostly they differ in one place. */
static void copy_shared(ecs_table *t, uint32_t row, const ecs_table *from, uint32_t from_row)
{
    const ecs_column *a = t->columns + 1, *a_end = a + t->archetype->column_count;
    const ecs_column *b = from->columns + 1, *b_end = b + from->archetype->column_count;
    while (a < a_end && b < b_end) {
        if (a->id == b->id)
            copy_row(a++, row, b++, from_row);
        else if (a->id < b->id)
            a++;
        else
            b++;
    }
    if (t->depth && from->depth)
        ecs_parents(t)[row] = ecs_parents(from)[from_row];
}

uint32_t ecs_table_append(kd_world *w, ecs_table *t, kd_entity e, const ecs_table *from, uint32_t from_row)
{
    uint32_t row = t->count++;
    ecs_entities(t)[row] = e;
    stamp_row(w, t, row);
    if (from)
        copy_shared(t, row, from, from_row);
    return row;
}

void ecs_table_remove(kd_world *w, ecs_table *t, uint32_t row)
{
    uint32_t last = --t->count;
    if (row == last)
        return;
    for (uint32_t c = 0; c < t->column_count; c++)
        copy_row(&t->columns[c], row, &t->columns[c], last);
    stamp_row(w, t, row);
    ecs_place(w, ecs_entities(t)[row], t, row);
}

static void copy_rows(const ecs_column *to, uint32_t to_row, const ecs_column *from, uint32_t from_row,
                      uint32_t n)
{
    memcpy(to->data + (size_t)to_row * to->size, from->data + (size_t)from_row * from->size,
           (size_t)n * to->size);
}

static void place_rows(kd_world *w, const ecs_table *t, uint32_t row, uint32_t n)
{
    const kd_entity *entities = ecs_entities(t);
    for (uint32_t i = row; i < row + n; i++)
        ecs_place(w, entities[i], t, i);
}

void ecs_table_move_rows(kd_world *w, ecs_table *t, uint32_t row, uint32_t n, ecs_table *to)
{
    uint32_t first = to->count, after = t->count - row - n, fill = n < after ? n : after;
    const ecs_column *a = to->columns + 1, *a_end = a + to->archetype->column_count;
    const ecs_column *b = t->columns + 1, *b_end = b + t->archetype->column_count;
    copy_rows(&to->columns[0], first, &t->columns[0], row, n);
    while (a < a_end && b < b_end) {
        if (a->id == b->id)
            copy_rows(a++, first, b++, row, n);
        else if (a->id < b->id)
            a++;
        else
            b++;
    }
    if (to->depth && t->depth)
        copy_rows(a_end, first, b_end, row, n);
    to->count += n;
    place_rows(w, to, first, n);
    ecs_table_stamp(w, to, first, n);
    for (uint32_t c = 0; c < t->column_count && fill; c++)
        copy_rows(&t->columns[c], row, &t->columns[c], t->count - fill, fill);
    t->count -= n;
    if (fill) {
        place_rows(w, t, row, fill);
        ecs_table_stamp(w, t, row, fill);
    }
}

void ecs_table_release_rows(kd_world *w, ecs_table *t, uint32_t row, uint32_t count)
{
    if (!t->archetype->hooked)
        return;
    for (uint32_t i = 0; i < t->archetype->id_count; i++) {
        kd_component_id id = t->archetype->ids[i];
        if (!w->components[id].desc->on_remove)
            continue;
        uint32_t c = t->column_of[id];
        for (uint32_t r = row; r < row + count; r++)
            ecs_release_value(w, id,
                              c == ECS_TAG_COLUMN ? (void *)w->tag_value
                                                  : t->columns[c].data + (size_t)r * t->columns[c].size);
    }
}

void ecs_tables_fini(kd_world *w)
{
    for (uint32_t i = 0; i < w->head.table_count; i++) {
        ecs_table_release_rows(w, w->head.tables[i], 0, w->head.tables[i]->count);
        table_free(w, w->head.tables[i]);
    }
    for (uint32_t i = 0; i < w->archetype_count; i++)
        archetype_free(w, w->archetypes[i]);
    ecs_free(w, w->head.tables);
    ecs_free(w, w->archetypes);
    ecs_free(w, w->archetype_slots);
}
