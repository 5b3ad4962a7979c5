/* Component descriptions and the ids that one world gave them. A lookup by the description's address is one
 * probe of an open hash that readers walk without a lock; an address seen for the first time is compared by
 * name under the lock, so that two copies of a description (two shared objects, two translation units) agree
 * on one id. */

#include <stdlib.h>

#include "runtime/ecs/internal.h"

static kd_component_id find_address(const kd_world *w, const kd_component_desc *desc)
{
    for (uint32_t s = ecs_desc_slot(desc);; s = (s + 1) & (ECS_DESC_SLOTS - 1)) {
        const kd_component_desc *key = __atomic_load_n(&w->head.desc_keys[s], __ATOMIC_ACQUIRE);
        if (key == desc)
            return w->head.desc_ids[s];
        if (!key)
            return 0;
    }
}

/* The lock is held. An address beyond the half is simply found by name every time. */
static void remember_address(kd_world *w, const kd_component_desc *desc, kd_component_id id)
{
    if (w->desc_slots_used >= ECS_DESC_SLOTS / 2)
        return;
    uint32_t s = ecs_desc_slot(desc);
    while (__atomic_load_n(&w->head.desc_keys[s], __ATOMIC_RELAXED))
        s = (s + 1) & (ECS_DESC_SLOTS - 1);
    w->head.desc_ids[s] = (uint16_t)id;
    __atomic_store_n(&w->head.desc_keys[s], desc, __ATOMIC_RELEASE);
    w->desc_slots_used++;
}

kd_component_id kd_component_find(const kd_world *w, const char *name)
{
    uint32_t count = atomic_load_explicit(&w->component_count, memory_order_acquire);
    for (kd_component_id id = 1; id <= count; id++)
        if (strcmp(w->components[id].desc->name, name) == 0)
            return id;
    return 0;
}

static int by_offset(const void *a, const void *b)
{
    uint32_t x = ((const ecs_span *)a)->offset, y = ((const ecs_span *)b)->offset;
    return x < y ? -1 : x > y;
}

/* The bytes that have a meaning: the fields, without the padding between them; all bytes when no field is
 * described. */
static bool fill_spans(kd_world *w, ecs_component *c)
{
    const kd_component_desc *desc = c->desc;
    if (!desc->size || (!desc->field_count && desc->on_remove))
        return true;
    uint32_t count = desc->field_count ? desc->field_count : 1;
    c->spans = ecs_grow(w, NULL, 0, count * sizeof *c->spans);
    if (!c->spans)
        return false;
    c->spans[0] = (ecs_span){0, desc->size};
    for (uint32_t i = 0; i < desc->field_count; i++)
        c->spans[i] = (ecs_span){desc->fields[i].offset, desc->fields[i].size};
    qsort(c->spans, count, sizeof *c->spans, by_offset);
    for (uint32_t i = 0; i < count; i++) {
        ecs_span *last = &c->spans[c->span_count ? c->span_count - 1 : 0];
        if (c->span_count && c->spans[i].offset <= last->offset + last->size) {
            uint32_t end = c->spans[i].offset + c->spans[i].size;
            if (end > last->offset + last->size)
                last->size = end - last->offset;
        } else {
            c->spans[c->span_count++] = c->spans[i];
        }
    }
    return true;
}

static bool is_mixed(const kd_component_desc *desc)
{
    return desc->flags & KD_COMPONENT_RELATION && desc->flags & (KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE);
}

static bool is_possible(const kd_component_desc *desc)
{
    return !is_mixed(desc) && desc->align <= 64;
}

static void refuse(const kd_component_desc *desc)
{
    if (is_mixed(desc))
        kd_fail(KD_UNSUPPORTED,
                "component %s: a relation lies beside the tables as it is and has no enable "
                "bits; declare it without these flags",
                desc->name);
    else
        kd_fail(KD_UNSUPPORTED, "component %s: wants its values at multiples of %u bytes; 64 is the most",
                desc->name, desc->align);
}

/* The lock is held. */
static kd_component_id register_component(kd_world *w, const kd_component_desc *desc)
{
    uint32_t count = atomic_load_explicit(&w->component_count, memory_order_relaxed);
    if (count == ECS_MAX_COMPONENTS) {
        kd_fail(KD_TOO_LARGE, "component %s: a world holds at most %u components; use fewer kinds",
                desc->name, ECS_MAX_COMPONENTS);
        return 0;
    }
    if (!is_possible(desc)) {
        refuse(desc);
        return 0;
    }
    ecs_component *c = &w->components[count + 1];
    *c = (ecs_component){.desc = desc, .size = desc->size};
    for (uint32_t i = 0; i < desc->field_count; i++)
        c->has_entities |= desc->fields[i].type == KD_ENTITY;
    if (!fill_spans(w, c))
        return 0;
    c->sparse = desc->flags & (KD_COMPONENT_SPARSE | KD_COMPONENT_RELATION);
    if (desc->flags & KD_COMPONENT_RELATION) {
        w->relation_ids[w->relation_count++] = count + 1;
        c->relation = w->relation_count;
    }
    if (desc->flags & (KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE))
        w->side_ids[w->side_count++] = count + 1;
    c->side = desc->flags & (KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE) ? w->side_count : 0;
    w->head.sparse_count += c->sparse;
    atomic_store_explicit(&w->component_count, count + 1, memory_order_release);
    return count + 1;
}

kd_component_id ecs_component_ensure_slow(kd_world *w, const kd_component_desc *desc)
{
    pthread_mutex_lock(&w->lock);
    kd_component_id id = find_address(w, desc);
    if (!id) {
        id = kd_component_find(w, desc->name);
        if (id && w->components[id].size != desc->size) {
            kd_fail(KD_BAD_FORMAT,
                    "component %s: described twice with different sizes (%u and %u bytes); rename one",
                    desc->name, w->components[id].size, desc->size);
            id = 0;
        } else {
            if (!id)
                id = register_component(w, desc);
            if (id)
                remember_address(w, desc, id);
        }
    }
    pthread_mutex_unlock(&w->lock);
    return id;
}

kd_status ecs_component_refusal(const kd_world *w, const kd_component_desc *desc)
{
    if (kd_component_find(w, desc->name))
        return KD_BAD_FORMAT;
    if (kd_component_count(w) == ECS_MAX_COMPONENTS)
        return KD_TOO_LARGE;
    return is_possible(desc) ? KD_NO_MEMORY : KD_UNSUPPORTED;
}

const kd_component_desc *kd_component_info(const kd_world *w, kd_component_id id)
{
    return id && id <= kd_component_count(w) ? w->components[id].desc : NULL;
}

uint32_t kd_component_count(const kd_world *w)
{
    return atomic_load_explicit(&w->component_count, memory_order_acquire);
}

void ecs_release_value(const kd_world *w, kd_component_id id, void *value)
{
    const kd_component_desc *desc = w->components[id].desc;
    if (desc->on_remove)
        desc->on_remove(value, desc->hook_user);
}
