/* What components keep by entity, beside the tables: the values of sparse ones (a paged index by entity,
 * values packed in order of adding, the last one filling the gap of one that goes) and enable bits. Nothing
 * here moves a row. */

#include "runtime/ecs/internal.h"

/* ---- sides ---- */
ecs_side *ecs_side_ensure(kd_world *w, kd_component_id id)
{
    uint32_t side = w->components[id].side;
    if (side > w->side_limit) {
        if (!ecs_reserve(w, &w->sides, &w->side_capacity, w->side_limit, side, sizeof *w->sides))
            return NULL;
        memset(w->sides + w->side_limit, 0, (w->side_capacity - w->side_limit) * sizeof *w->sides);
        w->side_limit = w->side_capacity;
    }
    return &w->sides[side - 1];
}

static bool pages_reserve(kd_world *w, ecs_side *s, uint32_t index)
{
    uint32_t page = index / ECS_PAGE, limit = s->page_limit;
    if (page >= limit) {
        if (!ecs_reserve(w, &s->pages, &s->page_limit, limit, page + 1, sizeof *s->pages))
            return false;
        for (uint32_t i = limit; i < s->page_limit; i++)
            s->pages[i] = NULL;
    }
    if (s->pages[page])
        return true;
    s->pages[page] = ecs_grow(w, NULL, 0, ECS_PAGE * sizeof **s->pages);
    if (s->pages[page])
        memset(s->pages[page], 0, ECS_PAGE * sizeof **s->pages);
    return s->pages[page] != NULL;
}

bool ecs_side_reserve(kd_world *w, kd_component_id id, uint32_t index, uint32_t n)
{
    ecs_side *s = ecs_side_ensure(w, id);
    uint32_t size = w->components[id].size;
    if (s && index / ECS_PAGE < s->page_limit && s->pages[index / ECS_PAGE] &&
        n <= s->entity_capacity - s->count && (!size || n <= s->value_capacity - s->count))
        return true;
    return s && n <= ECS_ROW_MASK - s->count && pages_reserve(w, s, index) &&
           ecs_reserve(w, &s->entities, &s->entity_capacity, s->count, s->count + n, sizeof *s->entities) &&
           (!size || ecs_reserve(w, &s->values, &s->value_capacity, s->count, s->count + n, size));
}

void ecs_side_stamp(kd_world *w, ecs_side *s)
{
    ecs_raise_version(&s->version, atomic_load_explicit(&w->version, memory_order_relaxed));
}

/* ---- values ---- */
static void *value_at(const kd_world *w, kd_component_id id, const ecs_side *s, uint32_t place)
{
    uint32_t size = w->components[id].size;
    return size ? s->values + (size_t)place * size : (void *)(uintptr_t)w->tag_value;
}

void *ecs_side_find(const kd_world *w, kd_component_id id, uint32_t index)
{
    const ecs_side *s = ecs_side_of(w, id);
    uint32_t place = ecs_side_place(s, index);
    return place == ECS_NONE ? NULL : value_at(w, id, s, place);
}

void ecs_side_add(kd_world *w, kd_component_id id, kd_entity e, const void *value)
{
    ecs_side *s = ecs_side_of(w, id);
    uint32_t place = s->count++;
    s->pages[e.index / ECS_PAGE][e.index % ECS_PAGE] = place + 1;
    s->entities[place] = e;
    if (w->components[id].size)
        ecs_write_value(w, id, value_at(w, id, s, place), value);
    ecs_side_stamp(w, s);
}

static void replace(kd_world *w, kd_component_id id, ecs_side *s, uint32_t place, const void *value)
{
    void *to = value_at(w, id, s, place);
    if (!w->components[id].size || to == value)
        return;
    ecs_release_value(w, id, to);
    ecs_write_value(w, id, to, value);
    ecs_side_stamp(w, s);
}

kd_status ecs_side_set(kd_world *w, kd_component_id id, kd_entity e, const void *value)
{
    ecs_side *s = ecs_side_ensure(w, id);
    uint32_t place = ecs_side_place(s, e.index), size = w->components[id].size;
    if (!s)
        return KD_NO_MEMORY;
    if (place != ECS_NONE) {
        replace(w, id, s, place, value);
        return KD_OK;
    }
    uintptr_t base = (uintptr_t)s->values, at = (uintptr_t)value; /* the value may lie here, and move */
    bool inside = at && at >= base && at - base < (size_t)s->count * size;
    ecs_structure_changed(w, "kd_set");
    if (!ecs_side_reserve(w, id, e.index, 1))
        return KD_NO_MEMORY;
    s = ecs_side_of(w, id);
    ecs_side_add(w, id, e, inside ? s->values + (at - base) : value);
    return KD_OK;
}

void ecs_side_remove(kd_world *w, kd_component_id id, uint32_t index)
{
    ecs_side *s = ecs_side_of(w, id);
    uint32_t place = ecs_side_place(s, index), size = w->components[id].size;
    if (place == ECS_NONE)
        return;
    ecs_structure_changed(w, "kd_remove");
    ecs_side_disable(w, id, index, false);
    ecs_release_value(w, id, value_at(w, id, s, place));
    uint32_t last = --s->count;
    s->pages[index / ECS_PAGE][index % ECS_PAGE] = 0;
    if (place != last) {
        kd_entity e = s->entities[place] = s->entities[last];
        if (size)
            ecs_copy(s->values + (size_t)place * size, s->values + (size_t)last * size, size);
        s->pages[e.index / ECS_PAGE][e.index % ECS_PAGE] = place + 1;
    }
    ecs_side_stamp(w, s);
}

/* ---- enable bits ---- */
static bool bits_reserve(kd_world *w, ecs_side *s, uint32_t index)
{
    uint32_t limit = s->word_limit;
    if (index / 64 < limit)
        return true;
    if (!ecs_reserve(w, &s->disabled, &s->word_limit, limit, index / 64 + 1, sizeof *s->disabled))
        return false;
    memset(s->disabled + limit, 0, (s->word_limit - limit) * sizeof *s->disabled);
    return true;
}

bool ecs_side_disable(kd_world *w, kd_component_id id, uint32_t index, bool disabled)
{
    ecs_side *s = ecs_side_of(w, id);
    if (ecs_side_disabled(s, index) == disabled)
        return true;
    s = ecs_side_ensure(w, id);
    if (!s || !bits_reserve(w, s, index))
        return false;
    s->disabled[index / 64] ^= (uint64_t)1 << index % 64;
    s->disabled_count += disabled ? 1u : UINT32_MAX;
    if (w->components[id].sparse)
        ecs_side_stamp(w, s);
    return true;
}

/* ---- all sides ---- */
void ecs_sides_drop(kd_world *w, uint32_t index)
{
    for (uint32_t i = 0; i < w->side_limit && i < w->side_count; i++) {
        ecs_side_disable(w, w->side_ids[i], index, false);
        if (w->components[w->side_ids[i]].sparse)
            ecs_side_remove(w, w->side_ids[i], index);
    }
}

void ecs_sides_fini(kd_world *w)
{
    for (uint32_t i = 0; i < w->side_limit; i++) {
        ecs_side *s = &w->sides[i];
        for (uint32_t place = 0; place < s->count; place++)
            ecs_release_value(w, w->side_ids[i], value_at(w, w->side_ids[i], s, place));
        for (uint32_t page = 0; page < s->page_limit; page++)
            ecs_free(w, s->pages[page]);
        ecs_free(w, s->pages);
        ecs_free(w, s->entities);
        ecs_free(w, s->values);
        ecs_free(w, s->disabled);
    }
    ecs_free(w, w->sides);
}
