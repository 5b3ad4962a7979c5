/* A 64-bit checksum of what the world holds, in a defined order: tables as they were made, rows as they lie.
 * Components count by name, and only the bytes their fields describe, so that padding and pointers do not
 * disturb. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/internal.h"

static void add_text(XXH3_state_t *state, const char *text)
{
    XXH3_64bits_update(state, text, strlen(text) + 1);
}

static void add_u32(XXH3_state_t *state, uint32_t value)
{
    XXH3_64bits_update(state, &value, sizeof value);
}

static void add_spans(XXH3_state_t *state, const ecs_component *c, const uint8_t *data, uint32_t count)
{
    if (c->span_count == 1 && c->spans[0].size == c->size) {
        XXH3_64bits_update(state, data, (size_t)count * c->size);
        return;
    }
    for (uint32_t row = 0; row < count; row++, data += c->size)
        for (uint32_t s = 0; s < c->span_count; s++)
            XXH3_64bits_update(state, data + c->spans[s].offset, c->spans[s].size);
}

/* Only rows that have something add to the sum: an array that once was longer must not show. */
static void add_hierarchy(XXH3_state_t *state, const kd_world *w, const ecs_table *t)
{
    if (t->depth)
        XXH3_64bits_update(state, ecs_parents(t), t->count * sizeof(kd_entity));
    for (uint32_t row = 0; row < t->count && w->node_limit; row++) {
        uint32_t index = ecs_entities(t)[row].index;
        uint32_t link[3] = {index, ecs_first_child(w, index),
                            index < w->node_limit ? w->nodes[index].next : ECS_NONE};
        if (link[1] != ECS_NONE || link[2] != ECS_NONE)
            XXH3_64bits_update(state, link, sizeof link);
    }
}

static void add_names(XXH3_state_t *state, const kd_world *w, const ecs_table *t)
{
    for (uint32_t row = 0; row < t->count && w->name_limit; row++) {
        uint32_t index = ecs_entities(t)[row].index;
        uint32_t group = index < w->name_limit ? w->name_links[index].group : 0;
        if (!group)
            continue;
        add_u32(state, index);
        add_text(state, w->name_groups[group - 1].text);
    }
}

/* The archetype's components ordered by name: ids depend on which of them happened to be used first. */
static uint32_t order_by_name(const kd_world *w, const ecs_archetype *a, kd_component_id *ids)
{
    for (uint32_t i = 0; i < a->id_count; i++) {
        uint32_t at = i;
        for (; at && strcmp(w->components[ids[at - 1]].desc->name, w->components[a->ids[i]].desc->name) > 0;
             at--)
            ids[at] = ids[at - 1];
        ids[at] = a->ids[i];
    }
    return a->id_count;
}

static void add_table(XXH3_state_t *state, const kd_world *w, const ecs_table *t)
{
    kd_component_id ids[ECS_MAX_COMPONENTS];
    uint32_t count = order_by_name(w, t->archetype, ids);
    add_u32(state, t->depth);
    add_u32(state, t->count);
    XXH3_64bits_update(state, ecs_entities(t), t->count * sizeof(kd_entity));
    add_hierarchy(state, w, t);
    add_names(state, w, t);
    for (uint32_t i = 0; i < count; i++) {
        const ecs_component *c = &w->components[ids[i]];
        add_text(state, c->desc->name);
        if (c->size)
            add_spans(state, c, t->columns[t->column_of[ids[i]]].data, t->count);
    }
}

/* What lies beside the tables, if anything does; components by name. */
static void add_sides(XXH3_state_t *state, const kd_world *w)
{
    ecs_archetype all = {.ids = (kd_component_id *)(uintptr_t)w->side_ids, .id_count = w->side_count};
    kd_component_id ids[ECS_MAX_COMPONENTS];
    uint32_t count = w->side_limit ? order_by_name(w, &all, ids) : 0;
    for (uint32_t i = 0; i < count; i++) {
        const ecs_component *c = &w->components[ids[i]];
        const ecs_side *s = ecs_side_of(w, ids[i]);
        if (!s || (!s->count && !s->disabled_count))
            continue;
        add_text(state, c->desc->name);
        add_u32(state, s->count);
        if (s->count)
            XXH3_64bits_update(state, s->entities, s->count * sizeof *s->entities);
        if (s->count && c->size)
            add_spans(state, c, s->values, s->count);
        for (uint32_t index = 0; s->disabled_count && index < s->word_limit * 64; index++)
            if (ecs_side_disabled(s, index))
                add_u32(state, index);
    }
}

/* Pairs by source, with the place that each has among the sources of its target: that is both orders. */
static void add_relation(XXH3_state_t *state, const ecs_component *c, const ecs_relation *r)
{
    for (uint32_t index = 0; index < r->targets.page_limit * ECS_RUN_PAGE; index++) {
        ecs_run run = ecs_run_of(&r->targets, index);
        if (!run.count)
            continue;
        uint32_t first = run.base + run.skip;
        add_u32(state, index);
        add_u32(state, run.count);
        XXH3_64bits_update(state, r->targets.entities + first, run.count * sizeof *r->targets.entities);
        XXH3_64bits_update(state, r->targets.places + first, run.count * sizeof *r->targets.places);
        if (c->size)
            add_spans(state, c, r->targets.values + (size_t)first * c->size, run.count);
    }
}

static void add_relations(XXH3_state_t *state, const kd_world *w)
{
    ecs_archetype all = {.ids = (kd_component_id *)(uintptr_t)w->relation_ids, .id_count = w->relation_count};
    kd_component_id ids[ECS_MAX_COMPONENTS];
    uint32_t count = w->pair_count ? order_by_name(w, &all, ids) : 0;
    for (uint32_t i = 0; i < count; i++) {
        const ecs_relation *r = ecs_relation_of(w, ids[i]);
        if (!r || !r->pair_count)
            continue;
        add_text(state, w->components[ids[i]].desc->name);
        add_relation(state, &w->components[ids[i]], r);
    }
}

uint64_t kd_world_checksum(const kd_world *w)
{
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    for (uint32_t i = 0; i < w->head.table_count; i++)
        if (w->head.tables[i]->count)
            add_table(&state, w, w->head.tables[i]);
    add_sides(&state, w);
    add_relations(&state, w);
    return XXH3_64bits_digest(&state);
}
