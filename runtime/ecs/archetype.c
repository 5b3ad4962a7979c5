/* Archetypes: the sets of components that are in use. An archetype is found through cached edges: one array
 * by component id says where adding (or, if here, removing) it leads; a hash of the ids finds it the first
 * time. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/internal.h"

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

void ecs_archetype_free(kd_world *w, ecs_archetype *a)
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
        ecs_archetype_free(w, a);
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

ecs_archetype *ecs_archetype_ensure(kd_world *w, const kd_component_id *ids, uint32_t count)
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

bool ecs_archetypes_init(kd_world *w)
{
    size_t bytes = (ECS_MAX_COMPONENTS + 1) * sizeof *w->head.places;
    w->head.places = ecs_grow(w, NULL, 0, bytes);
    if (w->head.places)
        memset(w->head.places, 0, bytes);
    return w->head.places && ecs_archetype_ensure(w, NULL, 0);
}

/* The archetype with `id` added, or removed if it is here. */
ecs_archetype *ecs_archetype_toggle(kd_world *w, ecs_archetype *a, kd_component_id id)
{
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
    ecs_archetype *other = ecs_archetype_ensure(w, ids, count);
    if (!other || !edges_reserve(w, a, id) || !edges_reserve(w, other, id))
        return NULL;
    a->edges[id] = other->index;
    other->edges[id] = a->index;
    return other;
}
