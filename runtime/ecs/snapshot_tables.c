/* Tables, handles and children out of the bytes of a snapshot.
 *
 * Going back to an earlier state of the same world is what restoring is for, so most tables are there
 * already, at the same place and large enough. Such a table's blocks are lent: while everything is checked,
 * the new table's columns point into the bytes; when nothing can fail any more it takes the blocks, and the
 * columns are copied into them. No memory is asked of the system, and no page is touched for the first time.
 */

#include "runtime/ecs/snapshot_reader.h"

#define MOST_SPARE 4u /* a block is not taken when it is so many times larger than what it will hold */

/* ---- tables ---- */
/* May the new table, which is to hold `rows`, take the blocks of the old one at its place? */
static ecs_table *find_lender(const snapshot_reader *in, const ecs_table *t, uint32_t rows)
{
    ecs_table *old = t->index < in->aside.table_count ? in->aside.tables[t->index] : NULL;
    const ecs_archetype *a = t->archetype, *b = old ? old->archetype : NULL;
    bool fits = old && rows && old->depth == t->depth && b->id_count == a->id_count && !b->hooked &&
                old->capacity >= rows && old->capacity / MOST_SPARE <= rows;
    bool aligned = ((uintptr_t)in->data & 7) == 0; /* handles are read where they lie meanwhile */
    return fits && aligned && (!a->id_count || memcmp(a->ids, b->ids, a->id_count * sizeof *a->ids) == 0)
               ? old
               : NULL;
}

/* The table is to hold more than what was lent for: it gets blocks of its own. */
static bool end_loan(const snapshot_reader *in, ecs_table *t)
{
    const uint8_t *bytes[ECS_MAX_COMPONENTS + 2];
    uint32_t count = t->count;
    for (uint32_t c = 0; c < t->column_count; c++) {
        bytes[c] = t->columns[c].data;
        t->columns[c].data = NULL;
    }
    in->lenders[t->index] = NULL;
    t->count = 0;
    if (!ecs_table_reserve(in->w, t, count))
        return false;
    t->count = count;
    for (uint32_t c = 0; c < t->column_count; c++)
        memcpy(t->columns[c].data, bytes[c], (size_t)count * t->columns[c].size);
    ecs_table_stamp(in->w, t, 0, count);
    return true;
}

/* Make room for more rows; the table has some when others differed only in components that are not written.
 */
static bool rows_reserve(const snapshot_reader *in, ecs_table *t, uint32_t rows)
{
    ecs_table **lender = &in->lenders[t->index];
    if (!t->count && !t->capacity && (*lender = find_lender(in, t, rows)))
        return true;
    if (*lender && !end_loan(in, t))
        return false;
    return rows <= ECS_ROW_MASK - t->count && ecs_table_reserve(in->w, t, t->count + rows);
}

/* Let a column hold, from row `first` on, what lies in the bytes: by pointing there until it gets the block
 * of the old one. */
static void fill_column(const snapshot_reader *in, ecs_table *t, uint32_t column, uint32_t first,
                        const void *bytes)
{
    ecs_column *c = &t->columns[column];
    if (in->lenders[t->index])
        c->data = (uint8_t *)(uintptr_t)bytes;
    else if (t->count > first)
        memcpy(c->data + (size_t)first * c->size, bytes, (size_t)(t->count - first) * c->size);
}

static kd_status place_entities(const snapshot_reader *in, const ecs_table *t, uint32_t first)
{
    const kd_entity *entities = ecs_entities(t);
    ecs_record *records = in->w->head.records;
    uint32_t limit = in->w->head.entity_limit, table = t->index;
    for (uint32_t row = first, count = t->count; row < count; row++) {
        kd_entity e = entities[row];
        if (e.index >= limit || e.generation - 1 >= ECS_MAX_GENERATION || records[e.index])
            return snapshot_damaged(in, "an entity has an impossible handle");
        records[e.index] = ecs_record_make(table, row, e.generation);
    }
    return KD_OK;
}

static kd_status read_columns(snapshot_reader *in, ecs_table *t, uint32_t first, const void *places,
                              const snapshot_table *record)
{
    for (uint32_t i = 0; i < record->component_count; i++) {
        kd_component_id id = in->ids[snapshot_u32(places, i)];
        const kd_component_desc *desc = in->w->components[id].desc;
        uint32_t c = t->column_of[id], count = record->row_count;
        if (desc->on_remove && count)
            return kd_fail(KD_BAD_FORMAT,
                           "%s: component %s owns memory here and cannot be restored from bytes", in->name,
                           desc->name);
        const void *values = snapshot_take(in, (uint64_t)count * desc->size);
        if (!values)
            return snapshot_damaged(in, "a table is cut off");
        if (c == ECS_TAG_COLUMN)
            continue;
        if (!snapshot_values_are_sane(desc, values, count))
            return snapshot_damaged(in,
                                    "a string without end, or a bool or word of an enumeration that is none");
        fill_column(in, t, c, first, values);
    }
    return KD_OK;
}

static ecs_table *table_of(snapshot_reader *in, const void *places, const snapshot_table *record)
{
    kd_component_id ids[ECS_MAX_COMPONENTS];
    for (uint32_t i = 0; i < record->component_count; i++) { /* places ascend by name, ids by registration */
        kd_component_id id = in->ids[snapshot_u32(places, i)];
        uint32_t at = i;
        for (; at && ids[at - 1] > id; at--)
            ids[at] = ids[at - 1];
        ids[at] = id;
    }
    ecs_archetype *a = ecs_archetype_ensure(in->w, ids, record->component_count);
    return a ? ecs_table_ensure(in->w, a, record->depth) : NULL;
}

/* The components are known, ascend, and lie in tables. */
static kd_status check_components(const snapshot_reader *in, const void *places, const snapshot_table *record)
{
    for (uint32_t i = 0; i < record->component_count; i++) {
        uint32_t place = snapshot_u32(places, i);
        if (place >= in->header.component_count || (i && place <= snapshot_u32(places, i - 1)))
            return snapshot_damaged(in, "a table's components are impossible");
        if (in->w->components[in->ids[place]].sparse)
            return snapshot_damaged(in, "a table has a component that lies beside the tables");
    }
    return KD_OK;
}

/* Let the rows that the record tells of follow those that the table has. */
static kd_status read_rows(snapshot_reader *in, ecs_table *t, const snapshot_table *record,
                           const void *places, const void *entities, const void *parents)
{
    uint32_t first = t->count;
    t->count += record->row_count;
    in->w->alive_count += record->row_count;
    fill_column(in, t, 0, first, entities);
    if (record->depth)
        fill_column(in, t, t->column_count - 1u, first, parents);
    kd_status status = place_entities(in, t, first);
    if (!status)
        status = read_columns(in, t, first, places, record);
    if (status)
        t->count = first; /* columns are not filled: nobody may look at these rows */
    else if (record->row_count && !in->lenders[t->index])
        ecs_table_stamp(in->w, t, first, record->row_count);
    return status;
}

kd_status snapshot_read_table(snapshot_reader *in)
{
    snapshot_table record;
    if (!snapshot_take_record(in, &record, sizeof record))
        return snapshot_damaged(in, "a table is cut off");
    /* Tables of every lesser depth were made before, so a depth cannot pass the number of tables. */
    if (record.depth > ECS_MAX_DEPTH || record.depth >= in->header.table_count ||
        record.component_count > in->header.component_count || record.row_count > in->header.alive_count)
        return snapshot_damaged(in, "a table has impossible counts");
    const void *places = snapshot_take(in, (uint64_t)record.component_count * sizeof(uint32_t));
    const void *entities = places ? snapshot_take(in, (uint64_t)record.row_count * sizeof(kd_entity)) : NULL;
    const void *parents = entities && record.depth
                              ? snapshot_take(in, (uint64_t)record.row_count * sizeof(kd_entity))
                              : entities;
    if (!parents)
        return snapshot_damaged(in, "a table is cut off");
    kd_status status = check_components(in, places, &record);
    if (status)
        return status;
    ecs_table *t = table_of(in, places, &record);
    if (!t || !rows_reserve(in, t, record.row_count))
        return snapshot_no_memory(in);
    return read_rows(in, t, &record, places, entities, parents);
}

/* ---- blocks of old tables ---- */
static void take_columns(kd_world *w, ecs_table *t, ecs_table *old)
{
    for (uint32_t c = 0; c < t->column_count; c++) {
        uint8_t *block = old->columns[c].data;
        memcpy(block, t->columns[c].data, (size_t)t->count * t->columns[c].size);
        t->columns[c].data = block;
        old->columns[c].data = NULL;
    }
    t->versions = old->versions; /* none is newer than what all rows are stamped with now */
    t->chunk_capacity = old->chunk_capacity;
    t->capacity = old->capacity;
    old->versions = NULL;
    old->count = old->capacity = old->chunk_capacity = 0;
    ecs_table_note_places(w, t);
    ecs_table_stamp(w, t, 0, t->count);
}

void snapshot_take_columns(snapshot_reader *in)
{
    for (uint32_t i = 0; i < in->w->head.table_count; i++)
        if (in->lenders[i])
            take_columns(in->w, in->w->head.tables[i], in->lenders[i]);
}

void snapshot_leave_columns(snapshot_reader *in)
{
    for (uint32_t i = 0; in->lenders && i < in->w->head.table_count; i++)
        for (uint32_t c = 0; in->lenders[i] && c < in->w->head.tables[i]->column_count; c++)
            in->w->head.tables[i]->columns[c].data = NULL;
}

/* ---- handles ---- */
kd_status snapshot_read_free(snapshot_reader *in)
{
    kd_world *w = in->w;
    const snapshot_header *h = &in->header;
    uint32_t resting = h->entity_limit - h->alive_count - h->free_count;
    const void *handles = snapshot_take(in, (uint64_t)h->free_count * sizeof(kd_entity));
    const void *rest = handles ? snapshot_take(in, (uint64_t)resting * sizeof(kd_entity)) : NULL;
    if (!rest)
        return snapshot_damaged(in, "the list of free handles is cut off");
    for (uint32_t i = h->free_count; i-- > 0;) {
        kd_entity e = snapshot_entity(handles, i);
        if (e.index >= h->entity_limit || e.generation < 2 || e.generation > ECS_MAX_GENERATION ||
            w->head.records[e.index])
            return snapshot_damaged(in, "a free handle is impossible");
        w->head.records[e.index] = ecs_record_make_free(w->free_first, e.generation);
        w->free_first = e.index;
        w->free_count++;
    }
    for (uint32_t i = 0; i < resting; i++) {
        uint32_t index = snapshot_entity(rest, i).index;
        if (index >= h->entity_limit || w->head.records[index])
            return snapshot_damaged(in, "a resting handle is impossible");
        w->head.records[index] = ECS_DEAD;
    }
    return KD_OK;
}

/* ---- children ---- */
/* Every row below the roots has a living parent one level up. Returns the number of such rows in *children.
 */
static kd_status check_parents(snapshot_reader *in, uint32_t *children)
{
    const kd_world *w = in->w;
    *children = 0;
    for (uint32_t i = 0; i < w->head.table_count; i++) {
        const ecs_table *t = w->head.tables[i];
        ecs_table *above;
        uint32_t row;
        for (uint32_t r = 0; t->depth && r < t->count; r++, ++*children)
            if (!ecs_parents(t)[r].generation || ecs_parents(t)[r].generation & ECS_PENDING ||
                !ecs_locate(w, ecs_parents(t)[r], &above, &row) || above->depth + 1u != t->depth)
                return snapshot_damaged(in, "an entity's parent is impossible");
    }
    return KD_OK;
}

kd_status snapshot_read_children(snapshot_reader *in)
{
    kd_world *w = in->w;
    uint32_t count = in->header.child_count, expected;
    const void *list = snapshot_take(in, (uint64_t)count * sizeof(uint32_t));
    if (!list)
        return snapshot_damaged(in, "the list of children is cut off");
    kd_status status = check_parents(in, &expected);
    if (status)
        return status;
    if (count != expected)
        return snapshot_damaged(in, "the list of children is impossible");
    if (count && !ecs_hierarchy_reserve(w, w->head.entity_limit - 1))
        return snapshot_no_memory(in);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t child = snapshot_u32(list, i);
        ecs_record r = child < w->head.entity_limit ? w->head.records[child] : 0;
        const ecs_table *t = ecs_record_generation(r) ? w->head.tables[ecs_record_table(r)] : NULL;
        uint32_t parent = t && t->depth ? ecs_parents(t)[ecs_record_row(r)].index : ECS_NONE;
        if (parent == ECS_NONE || w->nodes[child].previous != ECS_NONE || w->nodes[parent].first == child)
            return snapshot_damaged(in, "the list of children is impossible");
        ecs_hierarchy_link(w, child, parent);
    }
    return KD_OK;
}
