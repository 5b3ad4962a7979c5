/* Restoring a world from bytes that may be anything. The storage of the world (records, tables, hierarchy,
 * names) is put aside, a new one is built from the bytes and checked while it grows, and only then the old
 * one is released; an error puts the old one back.
 *
 * What the checks come to: every handle lies in exactly one place (a row, the list of free ones, or resting);
 * a parent is alive one level above its child, which rules out cycles; every child stands in one list of
 * siblings. The old blocks of a table may serve the new one (snapshot_tables.c). */

#define XXH_INLINE_ALL
#include <stdlib.h>
#include <xxhash.h>

#include "runtime/core/file.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/snapshot_reader.h"

kd_status snapshot_damaged(const snapshot_reader *in, const char *what)
{
    return kd_fail(KD_BAD_FORMAT, "%s: %s (at byte %zu); take another snapshot", in->name, what, in->at);
}

/* ---- reading ---- */
const void *snapshot_take(snapshot_reader *in, uint64_t size)
{
    uint64_t padded = (size + 7) & ~(uint64_t)7;
    if (padded > in->size - in->at)
        return NULL;
    const void *bytes = in->data + in->at;
    in->at += (size_t)padded;
    return bytes;
}

bool snapshot_take_record(snapshot_reader *in, void *record, size_t size)
{
    const void *bytes = snapshot_take(in, size);
    if (bytes)
        memcpy(record, bytes, size);
    return bytes != NULL;
}

static kd_status read_header(snapshot_reader *in)
{
    snapshot_header *h = &in->header;
    if (in->size < sizeof h->magic || memcmp(in->data, SNAPSHOT_MAGIC, sizeof h->magic) != 0)
        return kd_fail(KD_BAD_FORMAT,
                       "%s: this is no snapshot of a world; give a file that kd_snapshot_save wrote",
                       in->name);
    if (!snapshot_take_record(in, h, sizeof *h))
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
        return snapshot_damaged(in, "the counts in the header are impossible");
    return KD_OK;
}

static kd_status read_component(snapshot_reader *in, uint32_t place)
{
    snapshot_component record;
    char name[256];
    const void *text =
        snapshot_take_record(in, &record, sizeof record) ? snapshot_take(in, record.name_size) : NULL;
    if (!text)
        return snapshot_damaged(in, "the component table is cut off");
    if (record.name_size >= sizeof name)
        return snapshot_damaged(in, "a component's name is too long");
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
        return snapshot_damaged(in, "the component table is not in order");
    in->ids[place] = id;
    return KD_OK;
}

/* ---- values ---- */
static bool element_is_sane(const kd_field *f, const uint8_t *at, uint32_t size)
{
    uint32_t value;
    switch (f->type) {
    case KD_BOOL: return *at <= 1;
    case KD_STRING: return memchr(at, 0, size) != NULL;
    case KD_ENUM:
        memcpy(&value, at, sizeof value);
        for (uint32_t i = 0; f->enum_names; i++)
            if (!f->enum_names[i] || i == value)
                return f->enum_names[i] != NULL;
        return true;
    default: return true;
    }
}

bool snapshot_values_are_sane(const kd_component_desc *desc, const uint8_t *values, uint32_t count)
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
kd_status snapshot_no_memory(const snapshot_reader *in)
{
    return kd_fail(KD_NO_MEMORY, "%s: no memory to restore %u entities", in->name, in->header.alive_count);
}

static kd_status build(snapshot_reader *in)
{
    kd_world *w = in->w;
    const snapshot_header *h = &in->header;
    /* Every index has at least eight bytes further on, a table more: hostile counts cannot ask for more
     * memory than that. */
    if ((uint64_t)h->entity_limit * sizeof(kd_entity) > in->size ||
        (uint64_t)h->table_count * sizeof(snapshot_table) > in->size)
        return snapshot_damaged(in, "the counts in the header are impossible");
    in->lenders = ecs_grow(w, NULL, 0, (h->table_count + 1) * sizeof *in->lenders);
    if (in->lenders)
        memset(in->lenders, 0, (h->table_count + 1) * sizeof *in->lenders);
    if (!in->lenders || !ecs_archetypes_init(w) ||
        !ecs_reserve(w, &w->head.records, &w->record_capacity, 0, h->entity_limit, sizeof *w->head.records))
        return snapshot_no_memory(in);
    if (h->entity_limit)
        memset(w->head.records, 0, h->entity_limit * sizeof *w->head.records);
    w->head.entity_limit = h->entity_limit;
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < h->table_count && !status; i++)
        status = snapshot_read_table(in);
    if (!status && w->alive_count != h->alive_count)
        status = snapshot_damaged(in, "the number of entities is wrong");
    if (!status)
        status = snapshot_read_free(in);
    if (!status)
        status = snapshot_read_children(in);
    for (uint32_t i = 0; i < h->name_count && !status; i++)
        status = snapshot_read_name(in);
    if (!status)
        status = snapshot_check_singletons(in);
    for (uint32_t i = 0, last = ECS_NONE; i < h->side_count && !status; i++)
        status = snapshot_read_side(in, &last);
    for (uint32_t i = 0, last = ECS_NONE; i < h->relation_count && !status; i++)
        status = snapshot_read_relation(in, &last);
    if (!status && in->at != in->size)
        status = snapshot_damaged(in, "more bytes than belong to the snapshot");
    return status ? status : snapshot_walk_singletons(in, false);
}

static kd_status restore(kd_world *w, const void *data, size_t size, const char *name)
{
    snapshot_reader in = {.w = w, .name = name, .data = data, .size = size};
    if (kd_world_has_commands(w))
        return kd_fail(KD_UNSUPPORTED, "%s: commands wait to be applied; call kd_world_merge first", name);
    kd_status status = read_header(&in);
    for (uint32_t i = 0; i < in.header.component_count && !status; i++)
        status = read_component(&in, i);
    if (status)
        return status;
    snapshot_swap_storage(w, &in.aside); /* the world is bare now */
    w->name_group_free = ECS_NONE;
    status = build(&in);
    if (status)
        snapshot_leave_columns(&in);
    else
        snapshot_take_columns(&in);
    ecs_free(w, in.lenders);
    if (!status)
        snapshot_swap_storage(w, &in.aside);
    snapshot_drop_storage(w, &in.aside); /* the new one, in which nothing has a hook, or the old one */
    if (status)
        return status;
    snapshot_reset_singletons(w);
    snapshot_walk_singletons(&in, true);
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
