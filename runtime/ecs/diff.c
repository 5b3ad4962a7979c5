/* What makes two worlds different: entities are compared by handle, components by name. */

#include <stdio.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"

typedef struct comparison {
    const kd_world *a, *b;
    kd_component_id b_ids[ECS_MAX_COMPONENTS + 1]; /* of a's components, by their id; 0: unknown there */
    kd_component_id a_ids[ECS_MAX_COMPONENTS + 1];
    kd_difference *out;
    uint32_t capacity, count;
} comparison;

static void note(comparison *c, kd_difference d)
{
    if (c->count < c->capacity)
        c->out[c->count] = d;
    c->count++;
}

static kd_entity living_at(const kd_world *w, uint32_t index)
{
    ecs_record r = index < w->head.entity_limit ? w->head.records[index] : 0;
    return ecs_record_generation(r) ? (kd_entity){index, ecs_record_generation(r)} : KD_NO_ENTITY;
}

static bool spans_equal(const ecs_component *c, const uint8_t *x, const uint8_t *y)
{
    for (uint32_t i = 0; i < c->span_count; i++)
        if (memcmp(x + c->spans[i].offset, y + c->spans[i].offset, c->spans[i].size) != 0)
            return false;
    return true;
}

static const kd_field *first_field(const kd_component_desc *desc, const uint8_t *x, const uint8_t *y)
{
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (memcmp(x + desc->fields[i].offset, y + desc->fields[i].offset, desc->fields[i].size) != 0)
            return &desc->fields[i];
    return NULL;
}

static void compare_component(comparison *c, kd_entity e, kd_component_id id, kd_component_id other)
{
    const ecs_component *component = &c->a->components[id];
    const kd_component_desc *desc = component->desc;
    const void *x = kd_find_id(c->a, e, id), *y = other ? kd_find_id(c->b, e, other) : NULL;
    if (!x != !y) {
        note(c, (kd_difference){KD_DIFFERENCE_COMPONENT, e, x ? 0 : 1, desc, NULL, KD_NO_ENTITY});
        return;
    }
    bool enabled = kd_is_enabled_id(c->a, e, id);
    if (x && enabled != kd_is_enabled_id(c->b, e, other))
        note(c, (kd_difference){KD_DIFFERENCE_ENABLED, e, enabled ? 1 : 0, desc, NULL, KD_NO_ENTITY});
    if (x && component->size) {
        if (c->b->components[other].size != component->size)
            note(c, (kd_difference){KD_DIFFERENCE_VALUE, e, 0, desc, NULL, KD_NO_ENTITY});
        else if (!spans_equal(component, x, y))
            note(c, (kd_difference){KD_DIFFERENCE_VALUE, e, 0, desc, first_field(desc, x, y), KD_NO_ENTITY});
    }
}

/* ---- pairs ---- */
static void compare_pair(comparison *c, kd_entity e, kd_component_id id, kd_component_id other,
                         kd_entity target)
{
    const ecs_component *component = &c->a->components[id];
    const void *x = kd_pair_find_id(c->a, e, id, target), *y = kd_pair_find_id(c->b, e, other, target);
    if (!x != !y)
        note(c, (kd_difference){KD_DIFFERENCE_PAIR, e, x ? 0 : 1, component->desc, NULL, target});
    else if (component->size != c->b->components[other].size)
        note(c, (kd_difference){KD_DIFFERENCE_VALUE, e, 0, component->desc, NULL, target});
    else if (component->size && !spans_equal(component, x, y))
        note(c, (kd_difference){KD_DIFFERENCE_VALUE, e, 0, component->desc,
                                first_field(component->desc, x, y), target});
}

static bool lists_equal(kd_entities x, kd_entities y)
{
    return x.count == y.count && (!x.count || memcmp(x.at, y.at, x.count * sizeof *x.at) == 0);
}

/* The same sources in another order; sources that only one world has are told where they are. */
static bool sources_shuffled(const comparison *c, kd_entity e, kd_component_id id, kd_component_id other)
{
    kd_entities x = kd_sources_id(c->a, e, id), y = kd_sources_id(c->b, e, other);
    if (x.count != y.count || lists_equal(x, y))
        return false;
    for (uint32_t i = 0; i < x.count; i++)
        if (!kd_pair_find_id(c->b, x.at[i], other, e))
            return false;
    return true;
}

/* Pairs that only one has are told one by one; of an order that differs there is one word. */
static void compare_relation(comparison *c, kd_entity e, kd_component_id id, kd_component_id other)
{
    kd_entities x = kd_targets_id(c->a, e, id), y = kd_targets_id(c->b, e, other);
    uint32_t before = c->count;
    for (uint32_t i = 0; i < x.count; i++)
        compare_pair(c, e, id, other, x.at[i]);
    for (uint32_t i = 0; i < y.count; i++)
        if (!kd_pair_find_id(c->a, e, id, y.at[i]))
            compare_pair(c, e, id, other, y.at[i]);
    if (c->count == before && (!lists_equal(x, y) || sources_shuffled(c, e, id, other)))
        note(c,
             (kd_difference){KD_DIFFERENCE_PAIR_ORDER, e, 0, c->a->components[id].desc, NULL, KD_NO_ENTITY});
}

static void compare_components(comparison *c, kd_entity e)
{
    for (kd_component_id id = 1; id <= kd_component_count(c->a); id++)
        if (c->a->components[id].relation && c->b->components[c->b_ids[id]].relation)
            compare_relation(c, e, id, c->b_ids[id]);
        else
            compare_component(c, e, id, c->b_ids[id]);
    for (kd_component_id id = 1; id <= kd_component_count(c->b); id++)
        if (!c->a_ids[id] && kd_find_id(c->b, e, id))
            note(c, (kd_difference){KD_DIFFERENCE_COMPONENT, e, 1, c->b->components[id].desc, NULL,
                                    KD_NO_ENTITY});
}

static void compare_entity(comparison *c, kd_entity e)
{
    if (strcmp(kd_get_name(c->a, e), kd_get_name(c->b, e)) != 0)
        note(c, (kd_difference){.kind = KD_DIFFERENCE_NAME, .entity = e});
    if (!kd_entity_equal(kd_get_parent(c->a, e), kd_get_parent(c->b, e)))
        note(c, (kd_difference){.kind = KD_DIFFERENCE_PARENT, .entity = e});
    else if (!kd_entity_equal(kd_next_sibling(c->a, e), kd_next_sibling(c->b, e)))
        note(c, (kd_difference){.kind = KD_DIFFERENCE_SIBLING, .entity = e});
    compare_components(c, e);
}

/* The next entity in order of iteration. */
static kd_entity next_in_order(const kd_world *w, uint32_t *table, uint32_t *row)
{
    for (; *table < w->head.table_count; ++*table, *row = 0)
        if (*row < w->head.tables[*table]->count)
            return ecs_entities(w->head.tables[*table])[(*row)++];
    return KD_NO_ENTITY;
}

static void compare_order(comparison *c)
{
    uint32_t at[4] = {0};
    for (;;) {
        kd_entity x = next_in_order(c->a, &at[0], &at[1]), y = next_in_order(c->b, &at[2], &at[3]);
        if (!kd_entity_equal(x, y)) {
            note(c, (kd_difference){.kind = KD_DIFFERENCE_ORDER, .entity = x.generation ? x : y});
            return;
        }
        if (!x.generation)
            return;
    }
}

/* Sparse values have an order of their own; values that only one world has are told by now. */
static void compare_sparse_order(comparison *c, kd_component_id id, kd_component_id other)
{
    if (!ecs_is_sparse(c->a, id) || !other || !ecs_is_sparse(c->b, other))
        return;
    const ecs_side *x = ecs_side_of(c->a, id), *y = ecs_side_of(c->b, other);
    for (uint32_t i = 0; x && y && x->count == y->count && i < x->count; i++)
        if (!kd_entity_equal(x->entities[i], y->entities[i])) {
            note(c, (kd_difference){.kind = KD_DIFFERENCE_ORDER,
                                    .entity = x->entities[i],
                                    .component = c->a->components[id].desc});
            return;
        }
}

uint32_t kd_world_diff(const kd_world *a, const kd_world *b, kd_difference *out, uint32_t capacity)
{
    comparison c = {.a = a, .b = b, .out = out, .capacity = capacity};
    for (kd_component_id id = 1; id <= kd_component_count(a); id++) {
        c.b_ids[id] = kd_component_find(b, a->components[id].desc->name);
        c.a_ids[c.b_ids[id]] = id; /* entry 0 takes those without partner */
    }
    uint32_t limit =
        a->head.entity_limit > b->head.entity_limit ? a->head.entity_limit : b->head.entity_limit;
    for (uint32_t index = 0; index < limit; index++) {
        kd_entity x = living_at(a, index), y = living_at(b, index);
        if (kd_entity_equal(x, y)) {
            if (x.generation)
                compare_entity(&c, x);
            continue;
        }
        if (x.generation)
            note(&c, (kd_difference){.kind = KD_DIFFERENCE_ENTITY, .entity = x, .in = 0});
        if (y.generation)
            note(&c, (kd_difference){.kind = KD_DIFFERENCE_ENTITY, .entity = y, .in = 1});
    }
    compare_order(&c);
    for (kd_component_id id = 1; id <= kd_component_count(a); id++)
        compare_sparse_order(&c, id, c.b_ids[id]);
    return c.count;
}

const char *kd_difference_text(const kd_world *a, const kd_world *b, const kd_difference *d, char *out,
                               size_t out_size)
{
    const char *name = *kd_get_name(a, d->entity) ? kd_get_name(a, d->entity) : kd_get_name(b, d->entity);
    const char *in = d->in ? "second" : "first", *component = d->component ? d->component->name : "";
    int n = snprintf(out, out_size, "entity %u.%u%s%s: ", d->entity.index, d->entity.generation,
                     *name ? " " : "", name);
    char target[32] = "";
    if (d->target.generation)
        snprintf(target, sizeof target, "to %u.%u", d->target.index, d->target.generation);
    size_t used = n < 0 ? 0 : (size_t)n < out_size ? (size_t)n : out_size;
    char *at = out + used;
    size_t left = out_size - used;
    switch (d->kind) {
    case KD_DIFFERENCE_ENTITY: snprintf(at, left, "only in the %s world", in); break;
    case KD_DIFFERENCE_COMPONENT: snprintf(at, left, "%s only in the %s world", component, in); break;
    case KD_DIFFERENCE_VALUE:
        snprintf(at, left, "%s%s%s%s%s differs", component, *target ? " " : "", target, d->field ? "." : "",
                 d->field ? d->field->name : "");
        break;
    case KD_DIFFERENCE_ENABLED: snprintf(at, left, "%s disabled only in the %s world", component, in); break;
    case KD_DIFFERENCE_NAME:
        snprintf(at, left, "named \"%s\" and \"%s\"", kd_get_name(a, d->entity), kd_get_name(b, d->entity));
        break;
    case KD_DIFFERENCE_PARENT: snprintf(at, left, "another parent"); break;
    case KD_DIFFERENCE_PAIR: snprintf(at, left, "%s %s only in the %s world", component, target, in); break;
    case KD_DIFFERENCE_PAIR_ORDER: snprintf(at, left, "pairs of %s come in another order", component); break;
    case KD_DIFFERENCE_SIBLING: snprintf(at, left, "another sibling follows"); break;
    case KD_DIFFERENCE_ORDER:
        snprintf(at, left, "from here on the %s%s come in another order",
                 d->component ? "values of " : "entities", component);
        break;
    }
    return out;
}
