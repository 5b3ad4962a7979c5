/* Names. Entities of one name form a list in the order of naming, kept in a group that owns the text; groups
 * are found through an open hash of the text (linear probing, holes closed on removal). */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/internal.h"

static uint32_t slot_find(const kd_world *w, const char *name, uint64_t hash)
{
    uint32_t mask = w->name_slot_count - 1, s = (uint32_t)hash & mask;
    for (; w->name_slots[s]; s = (s + 1) & mask) {
        const ecs_name_group *g = &w->name_groups[w->name_slots[s] - 1];
        if (g->hash == hash && strcmp(g->text, name) == 0)
            break;
    }
    return s;
}

static bool slots_reserve(kd_world *w)
{
    if (w->name_slot_used * 2 < w->name_slot_count)
        return true;
    uint32_t count = w->name_slot_count ? w->name_slot_count * 2 : 64, mask = count - 1;
    uint32_t *slots = ecs_grow(w, NULL, 0, count * sizeof *slots);
    if (!slots)
        return false;
    memset(slots, 0, count * sizeof *slots);
    for (uint32_t i = 0; i < w->name_slot_count; i++) {
        if (!w->name_slots[i])
            continue;
        uint32_t s = (uint32_t)w->name_groups[w->name_slots[i] - 1].hash & mask;
        while (slots[s])
            s = (s + 1) & mask;
        slots[s] = w->name_slots[i];
    }
    ecs_free(w, w->name_slots);
    w->name_slots = slots;
    w->name_slot_count = count;
    return true;
}

static void slot_remove(kd_world *w, uint32_t hole)
{
    uint32_t mask = w->name_slot_count - 1;
    for (uint32_t s = (hole + 1) & mask; w->name_slots[s]; s = (s + 1) & mask) {
        uint32_t home = (uint32_t)w->name_groups[w->name_slots[s] - 1].hash & mask;
        if (((s - home) & mask) < ((s - hole) & mask))
            continue; /* its home lies behind the hole: it must stay */
        w->name_slots[hole] = w->name_slots[s];
        hole = s;
    }
    w->name_slots[hole] = 0;
    w->name_slot_used--;
}

/* Returns the group's index + 1, 0 when memory is out. */
static uint32_t group_ensure(kd_world *w, const char *name)
{
    size_t length = strlen(name);
    uint64_t hash = XXH3_64bits(name, length);
    if (!slots_reserve(w))
        return 0;
    uint32_t s = slot_find(w, name, hash);
    if (w->name_slots[s])
        return w->name_slots[s];
    char *text = ecs_grow(w, NULL, 0, length + 1);
    if (!text)
        return 0;
    uint32_t group = w->name_group_free;
    if (group != ECS_NONE) {
        w->name_group_free = w->name_groups[group].first;
    } else if (ecs_reserve(w, &w->name_groups, &w->name_group_capacity, w->name_group_count,
                           w->name_group_count + 1, sizeof *w->name_groups)) {
        group = w->name_group_count++;
    } else {
        ecs_free(w, text);
        return 0;
    }
    memcpy(text, name, length + 1);
    w->name_groups[group] = (ecs_name_group){text, hash, ECS_NONE, ECS_NONE};
    w->name_slots[s] = group + 1;
    w->name_slot_used++;
    return group + 1;
}

static void group_drop_if_empty(kd_world *w, uint32_t group)
{
    ecs_name_group *g = &w->name_groups[group];
    if (g->first != ECS_NONE)
        return;
    slot_remove(w, slot_find(w, g->text, g->hash));
    ecs_free(w, g->text);
    *g = (ecs_name_group){.first = w->name_group_free};
    w->name_group_free = group;
}

void ecs_name_drop(kd_world *w, uint32_t index)
{
    if (index >= w->name_limit || !w->name_links[index].group)
        return;
    ecs_name_link *link = &w->name_links[index];
    uint32_t group = link->group - 1;
    ecs_name_group *g = &w->name_groups[group];
    if (link->previous != ECS_NONE)
        w->name_links[link->previous].next = link->next;
    else
        g->first = link->next;
    if (link->next != ECS_NONE)
        w->name_links[link->next].previous = link->previous;
    else
        g->last = link->previous;
    link->group = 0;
    group_drop_if_empty(w, group);
}

static bool links_reserve(kd_world *w, uint32_t index)
{
    if (index < w->name_limit)
        return true;
    if (!ecs_reserve(w, &w->name_links, &w->name_capacity, w->name_limit, index + 1, sizeof *w->name_links))
        return false;
    memset(&w->name_links[w->name_limit], 0, (w->name_capacity - w->name_limit) * sizeof *w->name_links);
    w->name_limit = w->name_capacity;
    return true;
}

kd_status kd_set_name(kd_world *w, kd_entity e, const char *name)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return KD_NOT_FOUND;
    uint32_t index = ecs_entities(t)[row].index;
    if (!name || !*name) {
        ecs_name_drop(w, index);
        return KD_OK;
    }
    if (strcmp(kd_get_name(w, e), name) == 0)
        return KD_OK;
    uint32_t group = links_reserve(w, index) ? group_ensure(w, name) : 0;
    if (!group)
        return KD_NO_MEMORY;
    ecs_name_drop(w, index);
    ecs_name_group *g = &w->name_groups[group - 1];
    w->name_links[index] = (ecs_name_link){group, ECS_NONE, g->last};
    if (g->last != ECS_NONE)
        w->name_links[g->last].next = index;
    else
        g->first = index;
    g->last = index;
    return KD_OK;
}

const char *kd_get_name(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return "";
    uint32_t index = ecs_entities(t)[row].index;
    return index < w->name_limit && w->name_links[index].group
               ? w->name_groups[w->name_links[index].group - 1].text
               : "";
}

kd_entity kd_find_named(const kd_world *w, const char *name)
{
    if (!name || !*name || !w->name_slot_count)
        return KD_NO_ENTITY;
    uint32_t group = w->name_slots[slot_find(w, name, XXH3_64bits(name, strlen(name)))];
    return group ? ecs_handle_at(w, w->name_groups[group - 1].first) : KD_NO_ENTITY;
}

kd_entity kd_next_named(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return KD_NO_ENTITY;
    uint32_t index = ecs_entities(t)[row].index;
    if (index >= w->name_limit || !w->name_links[index].group || w->name_links[index].next == ECS_NONE)
        return KD_NO_ENTITY;
    return ecs_handle_at(w, w->name_links[index].next);
}

void ecs_names_fini(kd_world *w)
{
    for (uint32_t i = 0; i < w->name_group_count; i++)
        ecs_free(w, w->name_groups[i].text);
    ecs_free(w, w->name_groups);
    ecs_free(w, w->name_links);
    ecs_free(w, w->name_slots);
}
