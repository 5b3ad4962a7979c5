/* What a snapshot holds beside the tables: names, singletons, sparse values, enable bits, relations. Each is
 * checked against the tables, which were read before. */

#include "runtime/ecs/snapshot_reader.h"

/* ---- names ---- */
kd_status snapshot_read_name(snapshot_reader *in)
{
    snapshot_name record;
    const char *text =
        snapshot_take_record(in, &record, sizeof record) ? snapshot_take(in, record.text_size) : NULL;
    const void *list = text ? snapshot_take(in, (uint64_t)record.entity_count * sizeof(uint32_t)) : NULL;
    if (!list)
        return snapshot_damaged(in, "the names are cut off");
    if (!record.text_size || !record.entity_count || memchr(text, 0, record.text_size))
        return snapshot_damaged(in, "a name is impossible");
    char *name = ecs_grow(in->w, NULL, 0, (size_t)record.text_size + 1);
    kd_status status = name ? KD_OK : snapshot_no_memory(in);
    if (name) {
        memcpy(name, text, record.text_size);
        name[record.text_size] = 0;
    }
    for (uint32_t i = 0; i < record.entity_count && !status; i++) {
        uint32_t index = snapshot_u32(list, i);
        ecs_record r = index < in->w->head.entity_limit ? in->w->head.records[index] : 0;
        if (!ecs_record_generation(r) || *kd_get_name(in->w, ecs_handle_at(in->w, index)))
            status = snapshot_damaged(in, "a name belongs to no entity");
        else if (kd_set_name(in->w, ecs_handle_at(in->w, index), name))
            status = snapshot_no_memory(in);
    }
    ecs_free(in->w, name);
    return status;
}

/* ---- singletons ---- */
kd_status snapshot_check_singletons(snapshot_reader *in)
{
    in->singletons = in->data + in->at;
    for (uint32_t i = 0, last = 0; i < in->header.singleton_count; i++) {
        snapshot_singleton record;
        const void *value =
            snapshot_take_record(in, &record, sizeof record) ? snapshot_take(in, record.size) : NULL;
        if (!value)
            return snapshot_damaged(in, "the singletons are cut off");
        const kd_component_desc *desc = record.component < in->header.component_count
                                            ? in->w->components[in->ids[record.component]].desc
                                            : NULL;
        if (!desc || desc->size != record.size || (i && record.component <= last) || desc->on_remove ||
            !snapshot_values_are_sane(desc, value, 1))
            return snapshot_damaged(in, "a singleton is impossible");
        last = record.component;
    }
    return KD_OK;
}

kd_status snapshot_walk_singletons(const snapshot_reader *in, bool write)
{
    const uint8_t *at = in->singletons;
    for (uint32_t i = 0; i < in->header.singleton_count; i++) {
        snapshot_singleton record;
        memcpy(&record, at, sizeof record);
        at += sizeof record;
        void *value = kd_singleton_ensure(in->w, in->w->components[in->ids[record.component]].desc);
        if (!value)
            return snapshot_no_memory(in);
        if (write && record.size)
            memcpy(value, at, record.size);
        at += ((size_t)record.size + 7) & ~(size_t)7;
    }
    return KD_OK;
}

void snapshot_reset_singletons(kd_world *w)
{
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        const kd_component_desc *desc = w->components[id].desc;
        void *value = kd_singleton_find(w, id);
        if (value && !desc->on_remove && !(desc->flags & KD_COMPONENT_TRANSIENT))
            ecs_write_value(w, id, value, NULL);
    }
}

/* ---- sparse values and enable bits ---- */
static kd_status read_disabled(snapshot_reader *in, kd_component_id id, uint32_t count)
{
    kd_world *w = in->w;
    const void *list = snapshot_take(in, (uint64_t)count * sizeof(uint32_t));
    if (!list)
        return snapshot_damaged(in, "enable bits are cut off");
    for (uint32_t i = 0; i < count; i++) {
        uint32_t index = snapshot_u32(list, i);
        ecs_record r = index < w->head.entity_limit ? w->head.records[index] : 0;
        if (!ecs_record_generation(r) || (i && index <= snapshot_u32(list, i - 1)) ||
            !kd_find_id(w, ecs_handle_at(w, index), id))
            return snapshot_damaged(in, "an enable bit is impossible");
        if (!ecs_side_disable(w, id, index, true))
            return snapshot_no_memory(in);
    }
    return KD_OK;
}

static kd_status read_values(snapshot_reader *in, kd_component_id id, uint32_t count)
{
    kd_world *w = in->w;
    const ecs_component *c = &w->components[id];
    const void *entities = snapshot_take(in, (uint64_t)count * sizeof(kd_entity));
    const uint8_t *values = entities ? snapshot_take(in, (uint64_t)count * c->size) : NULL;
    if (!values)
        return snapshot_damaged(in, "sparse values are cut off");
    if (c->size && !snapshot_values_are_sane(c->desc, values, count))
        return snapshot_damaged(in, "a string without end, or a bool or word of an enumeration that is none");
    for (uint32_t i = 0; i < count; i++) {
        kd_entity e = snapshot_entity(entities, i);
        if (e.index >= w->head.entity_limit || !e.generation ||
            ecs_record_generation(w->head.records[e.index]) != e.generation || ecs_side_find(w, id, e.index))
            return snapshot_damaged(in, "a sparse value belongs to no entity");
        if (ecs_side_set(w, id, e, values + (size_t)i * c->size))
            return snapshot_no_memory(in);
    }
    return KD_OK;
}

kd_status snapshot_read_side(snapshot_reader *in, uint32_t *last)
{
    snapshot_side record;
    if (!snapshot_take_record(in, &record, sizeof record))
        return snapshot_damaged(in, "sparse values are cut off");
    if (record.component >= in->header.component_count || (*last != ECS_NONE && record.component <= *last))
        return snapshot_damaged(in, "sparse values of an impossible component");
    *last = record.component;
    kd_component_id id = in->ids[record.component];
    const ecs_component *c = &in->w->components[id];
    if (c->relation || (record.value_count && (!c->sparse || c->desc->on_remove)) ||
        (record.disabled_count && !(c->desc->flags & KD_COMPONENT_TOGGLE)))
        return snapshot_damaged(in, "sparse values or enable bits of a component that has none");
    kd_status status = read_values(in, id, record.value_count);
    return status ? status : read_disabled(in, id, record.disabled_count);
}

/* ---- relations ---- */
kd_status snapshot_read_relation(snapshot_reader *in, uint32_t *last)
{
    snapshot_relation record;
    if (!snapshot_take_record(in, &record, sizeof record))
        return snapshot_damaged(in, "a relation is cut off");
    if (record.component >= in->header.component_count || (*last != ECS_NONE && record.component <= *last))
        return snapshot_damaged(in, "pairs of an impossible component");
    *last = record.component;
    kd_component_id id = in->ids[record.component];
    const ecs_component *c = &in->w->components[id];
    if (!c->relation || c->desc->on_remove)
        return snapshot_damaged(in, "pairs of a component that has none");
    snapshot_pairs pairs = {.source_count = record.source_count, .pair_count = record.pair_count};
    pairs.sources = snapshot_take(in, (uint64_t)record.source_count * sizeof(kd_entity));
    pairs.counts = pairs.sources ? snapshot_take(in, (uint64_t)record.source_count * sizeof(uint32_t)) : NULL;
    pairs.targets = pairs.counts ? snapshot_take(in, (uint64_t)record.pair_count * sizeof(kd_entity)) : NULL;
    pairs.places = pairs.targets ? snapshot_take(in, (uint64_t)record.pair_count * sizeof(uint32_t)) : NULL;
    pairs.values = pairs.places ? snapshot_take(in, (uint64_t)record.pair_count * c->size) : NULL;
    if (!pairs.values)
        return snapshot_damaged(in, "a relation is cut off");
    if (c->size && !snapshot_values_are_sane(c->desc, pairs.values, record.pair_count))
        return snapshot_damaged(in, "a string without end, or a bool or word of an enumeration that is none");
    kd_status status = snapshot_relate(in->w, id, &pairs);
    return status == KD_BAD_FORMAT ? snapshot_damaged(in, "pairs are impossible")
           : status                ? snapshot_no_memory(in)
                                   : KD_OK;
}
