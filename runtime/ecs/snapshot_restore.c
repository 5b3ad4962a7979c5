/* Restoring a world from bytes that may be anything. The storage of the world (records, tables, hierarchy,
 * names) is put aside, a new one is built from the bytes and checked while it grows, and only then the old
 * one is released; an error puts the old one back. Queries keep two lists of matches meanwhile.
 *
 * What the checks come to: every handle lies in exactly one place (a row, the list of free ones, or resting);
 * a parent is alive one level above its child, which rules out cycles; every child stands in one list of
 * siblings. */

#define XXH_INLINE_ALL
#include <stdlib.h>
#include <xxhash.h>

#include "runtime/core/file.h"
#include "runtime/ecs/internal.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/snapshot_format.h"

#define STORAGE_BEGIN offsetof(kd_world, record_capacity)
#define STORAGE_END   offsetof(kd_world, queries)

typedef struct storage {
    ecs_record *records;
    uint32_t entity_limit, table_count;
    ecs_table **tables;
    ecs_places *places;
    uint8_t rest[STORAGE_END - STORAGE_BEGIN];
} storage;

typedef struct reader {
    kd_world *w;
    const char *name; /* of the file, for messages */
    const uint8_t *data;
    size_t at, size;
    snapshot_header header;
    kd_component_id ids[ECS_MAX_COMPONENTS]; /* by place in the component table */
    const uint8_t *singletons;
} reader;

static kd_status damaged(const reader *in, const char *what)
{
    return kd_fail(KD_BAD_FORMAT, "%s: %s (at byte %zu); take another snapshot", in->name, what, in->at);
}

/* ---- putting aside ---- */
static void swap_bytes(void *a, void *b, size_t size)
{
    uint8_t *x = a, *y = b;
    for (size_t i = 0; i < size; i++) {
        uint8_t byte = x[i];
        x[i] = y[i];
        y[i] = byte;
    }
}

/* Exchange the world's storage with `other`; the queries' lists of matches go with it. */
static void swap_storage(kd_world *w, storage *other)
{
    storage now = {w->head.records, w->head.entity_limit, w->head.table_count, w->head.tables,
                   w->head.places,  {0}};
    w->head.records = other->records;
    w->head.entity_limit = other->entity_limit;
    w->head.table_count = other->table_count;
    w->head.tables = other->tables;
    w->head.places = other->places;
    other->records = now.records;
    other->entity_limit = now.entity_limit;
    other->table_count = now.table_count;
    other->tables = now.tables;
    other->places = now.places;
    swap_bytes((uint8_t *)w + STORAGE_BEGIN, other->rest, sizeof other->rest);
    for (kd_query *q = w->queries; q; q = q->next) {
        swap_bytes(&q->matches, &q->kept_matches, sizeof q->matches);
        swap_bytes(&q->match_count, &q->kept_count, sizeof q->match_count);
        swap_bytes(&q->match_capacity, &q->kept_capacity, sizeof q->match_capacity);
    }
    memset(w->paths, 0, sizeof w->paths);
}

/* Release the storage that the world has now, hooks and all, and leave it with `next`. */
static void drop_storage(kd_world *w, storage *next)
{
    ecs_tables_fini(w);
    ecs_sides_fini(w);
    ecs_relations_fini(w);
    ecs_names_fini(w);
    ecs_free(w, w->head.records);
    ecs_free(w, w->nodes);
    swap_storage(w, next);
    for (kd_query *q = w->queries; q; q = q->next) {
        ecs_free(w, q->kept_matches);
        q->kept_matches = NULL;
        q->kept_count = q->kept_capacity = 0;
    }
}

/* ---- reading ---- */
/* The next `size` bytes and their filling, NULL when there are fewer. */
static const void *take(reader *in, uint64_t size)
{
    uint64_t padded = (size + 7) & ~(uint64_t)7;
    if (padded > in->size - in->at)
        return NULL;
    const void *bytes = in->data + in->at;
    in->at += (size_t)padded;
    return bytes;
}

static bool take_record(reader *in, void *record, size_t size)
{
    const void *bytes = take(in, size);
    if (bytes)
        memcpy(record, bytes, size);
    return bytes != NULL;
}

static uint32_t u32_at(const void *list, uint32_t i)
{
    uint32_t value;
    memcpy(&value, (const uint8_t *)list + (size_t)i * sizeof value, sizeof value);
    return value;
}

static kd_entity entity_at(const void *list, uint32_t i)
{
    kd_entity e;
    memcpy(&e, (const uint8_t *)list + (size_t)i * sizeof e, sizeof e);
    return e;
}

static kd_status read_header(reader *in)
{
    snapshot_header *h = &in->header;
    if (in->size < sizeof h->magic || memcmp(in->data, SNAPSHOT_MAGIC, sizeof h->magic) != 0)
        return kd_fail(KD_BAD_FORMAT,
                       "%s: this is no snapshot of a world; give a file that kd_snapshot_save wrote",
                       in->name);
    if (!take_record(in, h, sizeof *h))
        return kd_fail(KD_BAD_FORMAT, "%s: the snapshot is truncated (%zu bytes); take another", in->name,
                       in->size);
    if (h->byte_order != SNAPSHOT_BYTE_ORDER)
        return kd_fail(KD_UNSUPPORTED,
                       "%s: written on a machine of another byte order; restore it on such a machine",
                       in->name);
    if (h->version != SNAPSHOT_VERSION)
        return kd_fail(KD_UNSUPPORTED,
                       "%s: version %u of the format, this program reads %u; take another snapshot", in->name,
                       h->version, SNAPSHOT_VERSION);
    if (h->size != in->size)
        return kd_fail(KD_BAD_FORMAT, "%s: the snapshot has %zu bytes instead of %llu; take another",
                       in->name, in->size, (unsigned long long)h->size);
    if (h->checksum != XXH3_64bits(in->data + SNAPSHOT_HASHED, in->size - SNAPSHOT_HASHED))
        return kd_fail(KD_BAD_FORMAT, "%s: the snapshot is damaged (its checksum differs); take another",
                       in->name);
    if (h->component_count > ECS_MAX_COMPONENTS || h->table_count > ECS_MAX_TABLES ||
        h->entity_limit > ECS_ROW_MASK || (uint64_t)h->alive_count + h->free_count > h->entity_limit)
        return damaged(in, "the counts in the header are impossible");
    return KD_OK;
}

static kd_status read_component(reader *in, uint32_t place)
{
    snapshot_component record;
    char name[256];
    const void *text = take_record(in, &record, sizeof record) ? take(in, record.name_size) : NULL;
    if (!text)
        return damaged(in, "the component table is cut off");
    if (record.name_size >= sizeof name)
        return damaged(in, "a component's name is too long");
    memcpy(name, text, record.name_size);
    name[record.name_size] = 0;
    kd_component_id id = kd_component_find(in->w, name);
    const kd_component_desc *desc = kd_component_info(in->w, id);
    if (!desc)
        return kd_fail(KD_NOT_FOUND,
                       "%s: component %s is not known here; register it with kd_component_ensure", in->name,
                       name);
    if (desc->size != record.size || snapshot_field_hash(desc) != record.fields)
        return kd_fail(KD_BAD_FORMAT,
                       "%s: component %s was written with other fields (%u bytes, here %u); take another "
                       "snapshot with this program",
                       in->name, name, record.size, desc->size);
    if (place && strcmp(kd_component_info(in->w, in->ids[place - 1])->name, name) >= 0)
        return damaged(in, "the component table is not in order");
    in->ids[place] = id;
    return KD_OK;
}

/* ---- values ---- */
static bool element_is_sane(const kd_field *f, const uint8_t *at, uint32_t size)
{
    uint32_t value;
    switch (f->type) {
    case KD_BOOL:
        return *at <= 1;
    case KD_STRING:
        return memchr(at, 0, size) != NULL;
    case KD_ENUM:
        memcpy(&value, at, sizeof value);
        for (uint32_t i = 0; f->enum_names; i++)
            if (!f->enum_names[i] || i == value)
                return f->enum_names[i] != NULL;
        return true;
    default:
        return true;
    }
}

/* What a program may use as an index or a text without asking: bools, words of enumerations, strings. */
static bool values_are_sane(const kd_component_desc *desc, const uint8_t *values, uint32_t count)
{
    for (uint32_t i = 0; i < desc->field_count; i++) {
        const kd_field *f = &desc->fields[i];
        uint32_t elements = f->count ? f->count : 1, size = f->size / elements;
        if (f->type != KD_BOOL && f->type != KD_STRING && f->type != KD_ENUM)
            continue;
        for (uint32_t row = 0; row < count; row++)
            for (uint32_t e = 0; e < elements; e++)
                if (!element_is_sane(f, values + (size_t)row * desc->size + f->offset + (size_t)e * size,
                                     size))
                    return false;
    }
    return true;
}

/* ---- building ---- */
static kd_status no_memory(const reader *in)
{
    return kd_fail(KD_NO_MEMORY, "%s: no memory to restore %u entities", in->name, in->header.alive_count);
}

static kd_status place_entities(reader *in, ecs_table *t, uint32_t first, const void *entities,
                                uint32_t count)
{
    kd_world *w = in->w;
    for (uint32_t i = 0; i < count; i++) {
        kd_entity e = entity_at(entities, i);
        if (e.index >= w->head.entity_limit || !e.generation || e.generation > ECS_MAX_GENERATION ||
            w->head.records[e.index])
            return damaged(in, "an entity has an impossible handle");
        ecs_entities(t)[first + i] = e;
        ecs_place(w, e, t, first + i);
    }
    w->alive_count += count;
    return KD_OK;
}

static kd_status read_columns(reader *in, ecs_table *t, uint32_t first, const void *places,
                              const snapshot_table *record)
{
    for (uint32_t i = 0; i < record->component_count; i++) {
        kd_component_id id = in->ids[u32_at(places, i)];
        const kd_component_desc *desc = in->w->components[id].desc;
        uint32_t c = t->column_of[id], count = record->row_count;
        if (desc->on_remove && count)
            return kd_fail(KD_BAD_FORMAT,
                           "%s: component %s owns memory here and cannot be restored from bytes", in->name,
                           desc->name);
        const void *values = take(in, (uint64_t)count * desc->size);
        if (!values)
            return damaged(in, "a table is cut off");
        if (!count || c == ECS_TAG_COLUMN)
            continue;
        if (!values_are_sane(desc, values, count))
            return damaged(in, "a string without end, or a bool or word of an enumeration that is none");
        memcpy(t->columns[c].data + (size_t)first * desc->size, values, (size_t)count * desc->size);
    }
    return KD_OK;
}

static ecs_table *table_of(reader *in, const void *places, const snapshot_table *record)
{
    ecs_archetype *a = in->w->archetypes[0];
    for (uint32_t i = 0; i < record->component_count && a; i++)
        a = ecs_archetype_toggle(in->w, a, in->ids[u32_at(places, i)]);
    return a ? ecs_table_ensure(in->w, a, record->depth) : NULL;
}

static kd_status read_table(reader *in)
{
    snapshot_table record;
    if (!take_record(in, &record, sizeof record))
        return damaged(in, "a table is cut off");
    /* Tables of every lesser depth were made before, so a depth cannot pass the number of tables. */
    if (record.depth > ECS_MAX_DEPTH || record.depth >= in->header.table_count ||
        record.component_count > in->header.component_count || record.row_count > in->header.alive_count)
        return damaged(in, "a table has impossible counts");
    const void *places = take(in, (uint64_t)record.component_count * sizeof(uint32_t));
    const void *entities = places ? take(in, (uint64_t)record.row_count * sizeof(kd_entity)) : NULL;
    const void *parents =
        entities && record.depth ? take(in, (uint64_t)record.row_count * sizeof(kd_entity)) : entities;
    if (!parents)
        return damaged(in, "a table is cut off");
    for (uint32_t i = 0; i < record.component_count; i++)
        if (u32_at(places, i) >= in->header.component_count ||
            (i && u32_at(places, i) <= u32_at(places, i - 1)))
            return damaged(in, "a table's components are impossible");
    for (uint32_t i = 0; i < record.component_count; i++)
        if (in->w->components[in->ids[u32_at(places, i)]].sparse)
            return damaged(in, "a table has a component that lies beside the tables");
    ecs_table *t = table_of(in, places, &record);
    if (!t || record.row_count > ECS_ROW_MASK - t->count ||
        !ecs_table_reserve(in->w, t, t->count + record.row_count))
        return no_memory(in);
    uint32_t first = t->count;
    kd_status status = place_entities(in, t, first, entities, record.row_count);
    if (!status)
        status = read_columns(in, t, first, places, &record);
    if (status)
        return status;
    t->count += record.row_count;
    if (record.depth && record.row_count)
        memcpy(ecs_parents(t) + first, parents, record.row_count * sizeof(kd_entity));
    if (record.row_count)
        ecs_table_stamp(in->w, t, first, record.row_count);
    return KD_OK;
}

static kd_status read_free(reader *in)
{
    kd_world *w = in->w;
    const snapshot_header *h = &in->header;
    uint32_t resting = h->entity_limit - h->alive_count - h->free_count;
    const void *handles = take(in, (uint64_t)h->free_count * sizeof(kd_entity));
    const void *rest = handles ? take(in, (uint64_t)resting * sizeof(kd_entity)) : NULL;
    if (!rest)
        return damaged(in, "the list of free handles is cut off");
    for (uint32_t i = h->free_count; i-- > 0;) {
        kd_entity e = entity_at(handles, i);
        if (e.index >= h->entity_limit || e.generation < 2 || e.generation > ECS_MAX_GENERATION ||
            w->head.records[e.index])
            return damaged(in, "a free handle is impossible");
        w->head.records[e.index] = ecs_record_make_free(w->free_first, e.generation);
        w->free_first = e.index;
        w->free_count++;
    }
    for (uint32_t i = 0; i < resting; i++) {
        uint32_t index = entity_at(rest, i).index;
        if (index >= h->entity_limit || w->head.records[index])
            return damaged(in, "a resting handle is impossible");
        w->head.records[index] = ECS_DEAD;
    }
    return KD_OK;
}

/* Every row below the roots has a living parent one level up. Returns the number of such rows in *children.
 */
static kd_status check_parents(reader *in, uint32_t *children)
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
                return damaged(in, "an entity's parent is impossible");
    }
    return KD_OK;
}

static kd_status read_children(reader *in)
{
    kd_world *w = in->w;
    uint32_t count = in->header.child_count, expected;
    const void *list = take(in, (uint64_t)count * sizeof(uint32_t));
    if (!list)
        return damaged(in, "the list of children is cut off");
    kd_status status = check_parents(in, &expected);
    if (status)
        return status;
    if (count != expected)
        return damaged(in, "the list of children is impossible");
    if (count && !ecs_hierarchy_reserve(w, w->head.entity_limit - 1))
        return no_memory(in);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t child = u32_at(list, i);
        ecs_record r = child < w->head.entity_limit ? w->head.records[child] : 0;
        const ecs_table *t = ecs_record_generation(r) ? w->head.tables[ecs_record_table(r)] : NULL;
        uint32_t parent = t && t->depth ? ecs_parents(t)[ecs_record_row(r)].index : ECS_NONE;
        if (parent == ECS_NONE || w->nodes[child].previous != ECS_NONE || w->nodes[parent].first == child)
            return damaged(in, "the list of children is impossible");
        ecs_hierarchy_link(w, child, parent);
    }
    return KD_OK;
}

static kd_status read_name(reader *in)
{
    snapshot_name record;
    const char *text = take_record(in, &record, sizeof record) ? take(in, record.text_size) : NULL;
    const void *list = text ? take(in, (uint64_t)record.entity_count * sizeof(uint32_t)) : NULL;
    if (!list)
        return damaged(in, "the names are cut off");
    if (!record.text_size || !record.entity_count || memchr(text, 0, record.text_size))
        return damaged(in, "a name is impossible");
    char *name = ecs_grow(in->w, NULL, 0, (size_t)record.text_size + 1);
    kd_status status = name ? KD_OK : no_memory(in);
    if (name) {
        memcpy(name, text, record.text_size);
        name[record.text_size] = 0;
    }
    for (uint32_t i = 0; i < record.entity_count && !status; i++) {
        uint32_t index = u32_at(list, i);
        ecs_record r = index < in->w->head.entity_limit ? in->w->head.records[index] : 0;
        if (!ecs_record_generation(r) || *kd_get_name(in->w, ecs_handle_at(in->w, index)))
            status = damaged(in, "a name belongs to no entity");
        else if (kd_set_name(in->w, ecs_handle_at(in->w, index), name))
            status = no_memory(in);
    }
    ecs_free(in->w, name);
    return status;
}

static kd_status check_singletons(reader *in)
{
    in->singletons = in->data + in->at;
    for (uint32_t i = 0, last = 0; i < in->header.singleton_count; i++) {
        snapshot_singleton record;
        const void *value = take_record(in, &record, sizeof record) ? take(in, record.size) : NULL;
        if (!value)
            return damaged(in, "the singletons are cut off");
        const kd_component_desc *desc = record.component < in->header.component_count
                                            ? in->w->components[in->ids[record.component]].desc
                                            : NULL;
        if (!desc || desc->size != record.size || (i && record.component <= last) || desc->on_remove ||
            !values_are_sane(desc, value, 1))
            return damaged(in, "a singleton is impossible");
        last = record.component;
    }
    return KD_OK;
}

/* ---- beside the tables ---- */
static kd_status read_disabled(reader *in, kd_component_id id, uint32_t count)
{
    kd_world *w = in->w;
    const void *list = take(in, (uint64_t)count * sizeof(uint32_t));
    if (!list)
        return damaged(in, "enable bits are cut off");
    for (uint32_t i = 0; i < count; i++) {
        uint32_t index = u32_at(list, i);
        ecs_record r = index < w->head.entity_limit ? w->head.records[index] : 0;
        if (!ecs_record_generation(r) || (i && index <= u32_at(list, i - 1)) ||
            !kd_find_id(w, ecs_handle_at(w, index), id))
            return damaged(in, "an enable bit is impossible");
        if (!ecs_side_disable(w, id, index, true))
            return no_memory(in);
    }
    return KD_OK;
}

static kd_status read_values(reader *in, kd_component_id id, uint32_t count)
{
    kd_world *w = in->w;
    const ecs_component *c = &w->components[id];
    const void *entities = take(in, (uint64_t)count * sizeof(kd_entity));
    const uint8_t *values = entities ? take(in, (uint64_t)count * c->size) : NULL;
    if (!values)
        return damaged(in, "sparse values are cut off");
    if (c->size && !values_are_sane(c->desc, values, count))
        return damaged(in, "a string without end, or a bool or word of an enumeration that is none");
    for (uint32_t i = 0; i < count; i++) {
        kd_entity e = entity_at(entities, i);
        if (e.index >= w->head.entity_limit || !e.generation ||
            ecs_record_generation(w->head.records[e.index]) != e.generation || ecs_side_find(w, id, e.index))
            return damaged(in, "a sparse value belongs to no entity");
        if (ecs_side_set(w, id, e, values + (size_t)i * c->size))
            return no_memory(in);
    }
    return KD_OK;
}

static kd_status read_side(reader *in, uint32_t *last)
{
    snapshot_side record;
    if (!take_record(in, &record, sizeof record))
        return damaged(in, "sparse values are cut off");
    if (record.component >= in->header.component_count || (*last != ECS_NONE && record.component <= *last))
        return damaged(in, "sparse values of an impossible component");
    *last = record.component;
    kd_component_id id = in->ids[record.component];
    const ecs_component *c = &in->w->components[id];
    if (c->relation || (record.value_count && (!c->sparse || c->desc->on_remove)) ||
        (record.disabled_count && !(c->desc->flags & KD_COMPONENT_TOGGLE)))
        return damaged(in, "sparse values or enable bits of a component that has none");
    kd_status status = read_values(in, id, record.value_count);
    return status ? status : read_disabled(in, id, record.disabled_count);
}

/* ---- relations ---- */
static kd_status read_relation(reader *in, uint32_t *last)
{
    snapshot_relation record;
    if (!take_record(in, &record, sizeof record))
        return damaged(in, "a relation is cut off");
    if (record.component >= in->header.component_count || (*last != ECS_NONE && record.component <= *last))
        return damaged(in, "pairs of an impossible component");
    *last = record.component;
    kd_component_id id = in->ids[record.component];
    const ecs_component *c = &in->w->components[id];
    if (!c->relation || c->desc->on_remove)
        return damaged(in, "pairs of a component that has none");
    snapshot_pairs pairs = {.source_count = record.source_count, .pair_count = record.pair_count};
    pairs.sources = take(in, (uint64_t)record.source_count * sizeof(kd_entity));
    pairs.counts = pairs.sources ? take(in, (uint64_t)record.source_count * sizeof(uint32_t)) : NULL;
    pairs.targets = pairs.counts ? take(in, (uint64_t)record.pair_count * sizeof(kd_entity)) : NULL;
    pairs.places = pairs.targets ? take(in, (uint64_t)record.pair_count * sizeof(uint32_t)) : NULL;
    pairs.values = pairs.places ? take(in, (uint64_t)record.pair_count * c->size) : NULL;
    if (!pairs.values)
        return damaged(in, "a relation is cut off");
    if (c->size && !values_are_sane(c->desc, pairs.values, record.pair_count))
        return damaged(in, "a string without end, or a bool or word of an enumeration that is none");
    kd_status status = snapshot_relate(in->w, id, &pairs);
    return status == KD_BAD_FORMAT ? damaged(in, "pairs are impossible") : status ? no_memory(in) : KD_OK;
}

/* Go over the checked singletons: make room for each, or write them when nothing can fail any more. */
static kd_status walk_singletons(const reader *in, bool write)
{
    const uint8_t *at = in->singletons;
    for (uint32_t i = 0; i < in->header.singleton_count; i++) {
        snapshot_singleton record;
        memcpy(&record, at, sizeof record);
        at += sizeof record;
        void *value = kd_singleton_ensure(in->w, in->w->components[in->ids[record.component]].desc);
        if (!value)
            return no_memory(in);
        if (write && record.size)
            memcpy(value, at, record.size);
        at += ((size_t)record.size + 7) & ~(size_t)7;
    }
    return KD_OK;
}

static kd_status build(reader *in)
{
    kd_world *w = in->w;
    const snapshot_header *h = &in->header;
    /* Every index has at least eight bytes further on: hostile counts cannot ask for more memory than that.
     */
    if ((uint64_t)h->entity_limit * sizeof(kd_entity) > in->size)
        return damaged(in, "the counts in the header are impossible");
    if (!ecs_archetypes_init(w) ||
        !ecs_reserve(w, &w->head.records, &w->record_capacity, 0, h->entity_limit, sizeof *w->head.records))
        return no_memory(in);
    if (h->entity_limit)
        memset(w->head.records, 0, h->entity_limit * sizeof *w->head.records);
    w->head.entity_limit = h->entity_limit;
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < h->table_count && !status; i++)
        status = read_table(in);
    if (!status && w->alive_count != h->alive_count)
        status = damaged(in, "the number of entities is wrong");
    if (!status)
        status = read_free(in);
    if (!status)
        status = read_children(in);
    for (uint32_t i = 0; i < h->name_count && !status; i++)
        status = read_name(in);
    if (!status)
        status = check_singletons(in);
    for (uint32_t i = 0, last = ECS_NONE; i < h->side_count && !status; i++)
        status = read_side(in, &last);
    for (uint32_t i = 0, last = ECS_NONE; i < h->relation_count && !status; i++)
        status = read_relation(in, &last);
    if (!status && in->at != in->size)
        status = damaged(in, "more bytes than belong to the snapshot");
    return status ? status : walk_singletons(in, false);
}

static kd_status restore(kd_world *w, const void *data, size_t size, const char *name)
{
    reader in = {.w = w, .name = name, .data = data, .size = size};
    if (kd_world_has_commands(w))
        return kd_fail(KD_UNSUPPORTED, "%s: commands wait to be applied; call kd_world_merge first", name);
    kd_status status = read_header(&in);
    for (uint32_t i = 0; i < in.header.component_count && !status; i++)
        status = read_component(&in, i);
    if (status)
        return status;
    storage other = {0};
    swap_storage(w, &other); /* the world is bare now */
    w->name_group_free = ECS_NONE;
    status = build(&in);
    if (status) { /* nothing in the new storage has a hook */
        drop_storage(w, &other);
        return status;
    }
    swap_storage(w, &other);
    drop_storage(w, &other);
    walk_singletons(&in, true);
    ecs_structure_changed(w, "kd_snapshot_restore");
    return KD_OK;
}

kd_status kd_snapshot_restore(kd_world *w, const void *data, size_t size)
{
    return restore(w, data, size, "snapshot");
}

kd_status kd_snapshot_load(kd_world *w, const char *path)
{
    void *data;
    size_t size;
    kd_status status = kd_file_read(path, KD_FILE_NO_LIMIT, &data, &size);
    if (status)
        return status;
    status = restore(w, data, size, path);
    free(data);
    return status;
}
