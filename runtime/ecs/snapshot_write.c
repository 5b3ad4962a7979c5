/* Writing a world as one block of bytes. One function emits; it is run twice, first only to count, so that
 * the block is made once and in the right size. Components are listed by name, and tables refer to them by
 * place in that list: the bytes do not depend on the order in which a program registered its components. */

#define XXH_INLINE_ALL
#include <stdlib.h>
#include <xxhash.h>

#include "runtime/core/file.h"
#include "runtime/ecs/internal.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/snapshot_format.h"

typedef struct writer {
    const kd_world *w;
    uint8_t *data; /* NULL: only count */
    size_t at;
    uint32_t component_count;
    kd_component_id ids[ECS_MAX_COMPONENTS]; /* by place in the list */
    uint32_t places[ECS_MAX_COMPONENTS + 1]; /* by id; ECS_NONE: not in the list */
    snapshot_header header;
} writer;

uint64_t snapshot_field_hash(const kd_component_desc *desc)
{
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    for (uint32_t i = 0; i < desc->field_count; i++) {
        const kd_field *f = &desc->fields[i];
        uint32_t shape[4] = {(uint32_t)f->type, f->offset, f->size, f->count ? f->count : 1};
        XXH3_64bits_update(&state, f->name, strlen(f->name) + 1);
        XXH3_64bits_update(&state, shape, sizeof shape);
        for (const char *const *word = f->enum_names; word && *word; word++)
            XXH3_64bits_update(&state, *word, strlen(*word) + 1);
    }
    uint32_t stored = desc->flags & (KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE | KD_COMPONENT_RELATION |
                                     KD_COMPONENT_EXCLUSIVE);
    XXH3_64bits_update(&state, &stored, sizeof stored);
    return XXH3_64bits_digest(&state);
}

/* ---- emitting ---- */
static void emit(writer *out, const void *bytes, size_t size)
{
    size_t padded = (size + 7) & ~(size_t)7;
    if (out->data) {
        if (size)
            memcpy(out->data + out->at, bytes, size);
        memset(out->data + out->at + size, 0, padded - size);
    }
    out->at += padded;
}

/* Indices come one by one, in a list that is filled up only at its end. */
static void emit_index(writer *out, uint32_t index)
{
    if (out->data)
        memcpy(out->data + out->at, &index, sizeof index);
    out->at += sizeof index;
}

static void end_indices(writer *out)
{
    if (out->at % 8)
        emit_index(out, 0);
}

static void emit_components(writer *out)
{
    for (uint32_t i = 0; i < out->component_count; i++) {
        const kd_component_desc *desc = out->w->components[out->ids[i]].desc;
        snapshot_component record = {desc->size, (uint32_t)strlen(desc->name), snapshot_field_hash(desc)};
        emit(out, &record, sizeof record);
        emit(out, desc->name, record.name_size);
    }
}

static void emit_table(writer *out, const ecs_table *t)
{
    uint32_t places[ECS_MAX_COMPONENTS], count = 0;
    for (uint32_t i = 0; i < t->archetype->id_count; i++) {
        uint32_t place = out->places[t->archetype->ids[i]], at = count;
        if (place == ECS_NONE)
            continue;
        for (; at && places[at - 1] > place; at--)
            places[at] = places[at - 1];
        places[at] = place;
        count++;
    }
    snapshot_table record = {t->depth, t->count, count, 0};
    emit(out, &record, sizeof record);
    emit(out, places, count * sizeof *places);
    emit(out, ecs_entities(t), t->count * sizeof(kd_entity));
    if (t->depth)
        emit(out, ecs_parents(t), t->count * sizeof(kd_entity));
    for (uint32_t i = 0; i < count; i++) {
        uint32_t c = t->column_of[out->ids[places[i]]];
        if (c != ECS_TAG_COLUMN)
            emit(out, t->columns[c].data, (size_t)t->count * t->columns[c].size);
    }
}

static void emit_free(writer *out)
{
    const kd_world *w = out->w;
    uint32_t index = w->free_first;
    for (uint32_t i = 0; i < w->free_count; i++) {
        ecs_record r = w->head.records[index];
        kd_entity e = {index, ecs_record_next_generation(r)};
        emit(out, &e, sizeof e);
        index = ecs_record_row(r);
    }
    if (w->alive_count + w->free_count == w->head.entity_limit)
        return;
    for (index = 0; index < w->head.entity_limit; index++)
        if (w->head.records[index] == ECS_DEAD)
            emit(out, &(kd_entity){index, 0}, sizeof(kd_entity));
}

static void emit_children(writer *out)
{
    const kd_world *w = out->w;
    uint32_t count = 0;
    for (uint32_t parent = 0; parent < w->node_limit; parent++)
        for (uint32_t child = w->nodes[parent].first; child != ECS_NONE;
             child = w->nodes[child].next, count++)
            emit_index(out, child);
    end_indices(out);
    out->header.child_count = count;
}

static void emit_names(writer *out)
{
    const kd_world *w = out->w;
    out->header.name_count = 0;
    for (uint32_t g = 0; g < w->name_group_count; g++) {
        const ecs_name_group *group = &w->name_groups[g];
        if (!group->text)
            continue;
        snapshot_name record = {(uint32_t)strlen(group->text), 0};
        for (uint32_t i = group->first; i != ECS_NONE; i = w->name_links[i].next)
            record.entity_count++;
        emit(out, &record, sizeof record);
        emit(out, group->text, record.text_size);
        for (uint32_t i = group->first; i != ECS_NONE; i = w->name_links[i].next)
            emit_index(out, i);
        end_indices(out);
        out->header.name_count++;
    }
}

static void emit_singletons(writer *out)
{
    out->header.singleton_count = 0;
    for (uint32_t place = 0; place < out->component_count; place++) {
        const ecs_component *c = &out->w->components[out->ids[place]];
        const void *value =
            atomic_load_explicit(&((ecs_component *)(uintptr_t)c)->singleton, memory_order_acquire);
        if (!value || c->desc->on_remove)
            continue;
        snapshot_singleton record = {place, c->size};
        emit(out, &record, sizeof record);
        emit(out, value, c->size);
        out->header.singleton_count++;
    }
}

static void emit_side(writer *out, uint32_t place, const ecs_side *s)
{
    snapshot_side record = {place, s->count, s->disabled_count, 0};
    emit(out, &record, sizeof record);
    emit(out, s->entities, s->count * sizeof *s->entities);
    emit(out, s->values, (size_t)s->count * out->w->components[out->ids[place]].size);
    for (uint32_t index = 0; s->disabled_count && index < s->word_limit * 64; index++)
        if (ecs_side_disabled(s, index))
            emit_index(out, index);
    end_indices(out);
    out->header.side_count++;
}

static void emit_sides(writer *out)
{
    out->header.side_count = 0;
    for (uint32_t place = 0; place < out->component_count; place++) {
        const ecs_side *s = ecs_side_of(out->w, out->ids[place]);
        if (s && (s->count || s->disabled_count))
            emit_side(out, place, s);
    }
}

/* ---- relations ---- */
/* Bytes of a list that is filled up only at its end. */
static void emit_part(writer *out, const void *bytes, size_t size)
{
    if (out->data && size)
        memcpy(out->data + out->at, bytes, size);
    out->at += size;
}

static void end_parts(writer *out)
{
    static const uint8_t zeros[8];
    emit_part(out, zeros, -out->at & 7);
}

typedef enum pair_list { SOURCES, COUNTS, TARGETS, PLACES, VALUES } pair_list;

static void emit_pair_list(writer *out, const ecs_relation *r, pair_list list)
{
    const ecs_store *s = &r->targets;
    for (uint32_t index = 0; index < s->page_limit * ECS_RUN_PAGE; index++) {
        ecs_run run = ecs_run_of(s, index);
        size_t first = run.base + run.skip, count = run.count;
        if (!count)
            continue;
        if (list == SOURCES)
            emit_part(out, &(kd_entity){index, ecs_record_generation(out->w->head.records[index])}, 8);
        else if (list == COUNTS)
            emit_index(out, run.count);
        else if (list == TARGETS)
            emit_part(out, s->entities + first, count * sizeof *s->entities);
        else if (list == PLACES)
            emit_part(out, s->places + first, count * sizeof *s->places);
        else
            emit_part(out, s->values + first * s->value_size, count * s->value_size);
    }
    end_parts(out);
}

static void emit_relations(writer *out)
{
    out->header.relation_count = 0;
    for (uint32_t place = 0; place < out->component_count; place++) {
        const ecs_relation *r = ecs_relation_of(out->w, out->ids[place]);
        if (!r || !r->pair_count)
            continue;
        snapshot_relation record = {place, 0, r->pair_count, 0};
        for (uint32_t index = 0; index < r->targets.page_limit * ECS_RUN_PAGE; index++)
            record.source_count += ecs_run_of(&r->targets, index).count != 0;
        emit(out, &record, sizeof record);
        for (pair_list list = SOURCES; list < VALUES + (r->targets.value_size != 0); list++)
            emit_pair_list(out, r, list);
        out->header.relation_count++;
    }
}

static void emit_all(writer *out)
{
    const kd_world *w = out->w;
    out->at = sizeof out->header;
    emit_components(out);
    for (uint32_t i = 0; i < w->head.table_count; i++)
        emit_table(out, w->head.tables[i]);
    emit_free(out);
    emit_children(out);
    emit_names(out);
    emit_singletons(out);
    emit_sides(out);
    emit_relations(out);
}

/* ---- what belongs in ---- */
static bool is_used(const kd_world *w, kd_component_id id, bool with_rows)
{
    if (ecs_side_of(w, id) && ecs_side_of(w, id)->count)
        return true;
    if (ecs_relation_of(w, id) && ecs_relation_of(w, id)->pair_count)
        return true;
    for (uint32_t i = 0; i < w->head.table_count; i++)
        if (ecs_column_of(w->head.tables[i], id) && (!with_rows || w->head.tables[i]->count))
            return true;
    return false;
}

static kd_status list_components(writer *out)
{
    const kd_world *w = out->w;
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        const kd_component_desc *desc = w->components[id].desc;
        bool single = kd_singleton_find(w, id) && !desc->on_remove;
        out->places[id] = ECS_NONE;
        if (desc->flags & KD_COMPONENT_TRANSIENT || (!single && !is_used(w, id, false)))
            continue;
        if (desc->on_remove && is_used(w, id, true))
            return kd_fail(
                KD_UNSUPPORTED,
                "component %s: owns memory and cannot be written to a snapshot; remove it first or declare "
                "it KD_COMPONENT_TRANSIENT",
                desc->name);
        uint32_t at = out->component_count++;
        for (; at && strcmp(w->components[out->ids[at - 1]].desc->name, desc->name) > 0; at--)
            out->ids[at] = out->ids[at - 1];
        out->ids[at] = id;
    }
    for (uint32_t i = 0; i < out->component_count; i++)
        out->places[out->ids[i]] = i;
    return KD_OK;
}

static kd_status reserve(kd_snapshot *s, size_t size)
{
    if (size <= s->capacity)
        return KD_OK;
    void *data = malloc(size);
    if (!data)
        return kd_fail(KD_NO_MEMORY, "snapshot: no memory for %zu bytes", size);
    free(s->data);
    s->data = data;
    s->capacity = size;
    return KD_OK;
}

static void finish(writer *out)
{
    const kd_world *w = out->w;
    snapshot_header *h = &out->header;
    memcpy(h->magic, SNAPSHOT_MAGIC, sizeof h->magic);
    h->version = SNAPSHOT_VERSION;
    h->byte_order = SNAPSHOT_BYTE_ORDER;
    h->size = out->at;
    h->component_count = out->component_count;
    h->table_count = w->head.table_count;
    h->entity_limit = w->head.entity_limit;
    h->alive_count = w->alive_count;
    h->free_count = w->free_count;
    memcpy(out->data, h, sizeof *h);
    h->checksum = XXH3_64bits(out->data + SNAPSHOT_HASHED, out->at - SNAPSHOT_HASHED);
    memcpy(out->data, h, sizeof *h);
}

kd_status kd_snapshot_write(const kd_world *w, kd_snapshot *s)
{
    writer out = {.w = w};
    s->size = 0;
    if (kd_world_has_commands(w))
        return kd_fail(KD_UNSUPPORTED, "snapshot: commands wait to be applied; call kd_world_merge first");
    kd_status status = list_components(&out);
    if (status)
        return status;
    emit_all(&out);
    status = reserve(s, out.at);
    if (status)
        return status;
    out.data = s->data;
    emit_all(&out);
    finish(&out);
    s->size = out.at;
    return KD_OK;
}

void kd_snapshot_fini(kd_snapshot *s)
{
    free(s->data);
    *s = (kd_snapshot){0};
}

kd_status kd_snapshot_save(const kd_world *w, const char *path)
{
    kd_snapshot s = {0};
    kd_status status = kd_snapshot_write(w, &s);
    if (!status)
        status = kd_file_write(path, s.data, s.size);
    kd_snapshot_fini(&s);
    return status;
}
