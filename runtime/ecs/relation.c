/* Relating entities, and what happens to pairs when an entity dies. The pairs themselves are kept by pairs.c.
 */

#include "runtime/ecs/relation.h"
#include "runtime/ecs/internal.h"

/* ---- asking ---- */
static kd_entity living(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    return ecs_locate(w, e, &t, &row) ? ecs_entities(t)[row] : KD_NO_ENTITY;
}

uint32_t ecs_pair_item(const ecs_relation *r, kd_entity source, kd_entity target)
{
    ecs_run run = ecs_run_of(&r->targets, source.index);
    uint32_t place = !target.generation ? 0 : run.count ? ecs_pair_place(r, source, target) : ECS_NONE;
    return run.count && place != ECS_NONE ? run.base + run.skip + place : ECS_NONE;
}

void *ecs_relation_find(const kd_world *w, kd_component_id id, kd_entity source)
{
    const ecs_relation *r = ecs_relation_of(w, id);
    uint32_t item = r ? ecs_pair_item(r, source, KD_NO_ENTITY) : ECS_NONE;
    return item == ECS_NONE ? NULL : ecs_pair_value(w, id, r, item);
}

/* The id comes from outside: one that nobody gave is that of no relation. */
static const ecs_relation *known(const kd_world *w, kd_component_id id)
{
    return id <= ECS_MAX_COMPONENTS ? ecs_relation_of(w, id) : NULL;
}

const void *kd_pair_find_id(const kd_world *w, kd_entity source, kd_component_id relation, kd_entity target)
{
    const ecs_relation *r = known(w, relation);
    if (!r || !r->pair_count)
        return NULL;
    source = living(w, source);
    target = living(w, target);
    if (!source.generation || !target.generation)
        return NULL;
    uint32_t item = ecs_pair_item(r, source, target);
    return item == ECS_NONE ? NULL : ecs_pair_value(w, relation, r, item);
}

void *kd_pair_find_mut_id(kd_world *w, kd_entity source, kd_component_id relation, kd_entity target)
{
    ecs_watch_value(w, relation, true);
    void *value = (void *)(uintptr_t)kd_pair_find_id(w, source, relation, target);
    if (value)
        ecs_relation_stamp(w, ecs_relation_of(w, relation));
    return value;
}

static ecs_run targets_run(const kd_world *w, kd_entity source, kd_component_id relation)
{
    const ecs_relation *r = known(w, relation);
    source = r ? living(w, source) : KD_NO_ENTITY;
    return source.generation ? ecs_run_of(&r->targets, source.index) : (ecs_run){0};
}

kd_entities kd_targets_id(const kd_world *w, kd_entity source, kd_component_id relation)
{
    ecs_run run = targets_run(w, source, relation);
    if (!run.count)
        return (kd_entities){NULL, 0};
    return (kd_entities){ecs_relation_of(w, relation)->targets.entities + run.base + run.skip, run.count};
}

const void *kd_target_values_id(const kd_world *w, kd_entity source, kd_component_id relation)
{
    ecs_run run = targets_run(w, source, relation);
    if (!run.count || !w->components[relation].size)
        return NULL;
    return ecs_pair_value(w, relation, ecs_relation_of(w, relation), run.base + run.skip);
}

kd_entities kd_sources_id(const kd_world *w, kd_entity target, kd_component_id relation)
{
    const ecs_relation *r = known(w, relation);
    target = r ? living(w, target) : KD_NO_ENTITY;
    ecs_run run = target.generation ? ecs_run_of(&r->sources, target.index) : (ecs_run){0};
    return run.count ? (kd_entities){r->sources.entities + run.base, run.count} : (kd_entities){NULL, 0};
}

kd_entity kd_target_id(const kd_world *w, kd_entity source, kd_component_id relation)
{
    kd_entities targets = kd_targets_id(w, source, relation);
    return targets.count ? targets.at[0] : KD_NO_ENTITY;
}

uint32_t kd_pair_count_id(const kd_world *w, kd_component_id relation)
{
    const ecs_relation *r = known(w, relation);
    return r ? r->pair_count : 0;
}

/* ---- relating ---- */
bool ecs_needs_no_target(const kd_world *w, kd_component_id id)
{
    if (w->components[id].relation)
        kd_fail(KD_UNSUPPORTED, "component %s: is a relation and needs a target; use kd_relate",
                w->components[id].desc->name);
    return !w->components[id].relation;
}

void ecs_relation_stamp(kd_world *w, ecs_relation *r)
{
    ecs_raise_version(&r->version, atomic_load_explicit(&w->version, memory_order_relaxed));
}

static kd_status set_pair(kd_world *w, kd_component_id id, ecs_relation *r, kd_entity source, uint32_t item,
                          const void *value)
{
    void *to = ecs_pair_value(w, id, r, item);
    ecs_pair_event(w, KD_ON_SET, source, id, r->targets.entities[item], NULL);
    if (!w->components[id].size || to == value)
        return KD_OK;
    ecs_release_value(w, id, to);
    ecs_write_value(w, id, to, value);
    ecs_relation_stamp(w, r);
    return KD_OK;
}

static const void *value_or_null(const kd_world *w, kd_component_id id, const ecs_relation *r, uint32_t item)
{
    return w->components[id].size ? ecs_pair_value(w, id, r, item) : NULL;
}

/* The only pair of an exclusive relation gets another target. */
static kd_status move_pair(kd_world *w, kd_component_id id, ecs_relation *r, kd_entity source,
                           const void *value, kd_entity target)
{
    uint32_t item = ecs_pair_item(r, source, KD_NO_ENTITY);
    kd_entity former = r->targets.entities[item];
    if (!ecs_pair_retarget(w, r, source, item, target))
        return KD_NO_MEMORY;
    void *to = ecs_pair_value(w, id, r, item);
    ecs_pair_event(w, KD_ON_REMOVE, source, id, former, value_or_null(w, id, r, item));
    if (w->components[id].size && to != value) {
        ecs_release_value(w, id, to);
        ecs_write_value(w, id, to, value);
    }
    ecs_relation_stamp(w, r);
    ecs_pair_event(w, KD_ON_ADD, source, id, target, NULL);
    return KD_OK;
}

bool ecs_doomed_reserve(kd_world *w, kd_component_id id, uint32_t pairs)
{
    return !(w->components[id].desc->flags & KD_COMPONENT_CASCADE) ||
           (pairs <= UINT32_MAX - w->cascade_count &&
            ecs_reserve(w, &w->doomed, &w->doomed_capacity, 0, w->cascade_count + pairs, sizeof *w->doomed));
}

static kd_status add_pair(kd_world *w, kd_component_id id, ecs_relation *r, kd_entity source,
                          const void *value, kd_entity target)
{
    uintptr_t base = (uintptr_t)r->targets.values, at = (uintptr_t)value; /* it may lie here, and move */
    bool inside = base && at >= base && at - base < (size_t)r->targets.used * r->targets.value_size;
    if (!ecs_doomed_reserve(w, id, 1) || !ecs_pair_reserve(w, r, source.index, target.index))
        return KD_NO_MEMORY;
    uint32_t item = ecs_pair_add(w, r, source, target);
    w->cascade_count += (w->components[id].desc->flags & KD_COMPONENT_CASCADE) != 0;
    if (w->components[id].size)
        ecs_write_value(w, id, ecs_pair_value(w, id, r, item),
                        inside ? r->targets.values + (at - base) : value);
    ecs_relation_stamp(w, r);
    ecs_pair_event(w, KD_ON_ADD, source, id, target, NULL);
    return KD_OK;
}

kd_status ecs_relate_id(kd_world *w, kd_entity source, kd_component_id id, const void *value,
                        kd_entity target)
{
    if (!id)
        return KD_NO_MEMORY;
    if (!w->components[id].relation)
        return kd_fail(KD_UNSUPPORTED, "component %s: is no relation; define it with KD_RELATION_DEFINE",
                       w->components[id].desc->name);
    source = living(w, source);
    target = living(w, target);
    if (!source.generation || !target.generation)
        return KD_NOT_FOUND;
    ecs_relation *r = ecs_relation_ensure(w, id);
    if (!r)
        return KD_NO_MEMORY;
    uint32_t item = ecs_pair_item(r, source, target);
    if (item != ECS_NONE)
        return set_pair(w, id, r, source, item, value);
    ecs_structure_changed(w, "kd_relate");
    bool leaves =
        w->components[id].desc->flags & KD_COMPONENT_EXCLUSIVE && ecs_run_of(&r->targets, source.index).count;
    return leaves ? move_pair(w, id, r, source, value, target) : add_pair(w, id, r, source, value, target);
}

kd_status kd_relate_value(kd_world *w, kd_entity source, kd_value relation, kd_entity target)
{
    kd_component_id id = kd_component_ensure(w, relation.desc);
    kd_status status = ecs_relate_id(w, source, id, relation.value, target);
    ecs_events_settle(w);
    return status;
}

/* ---- unrelating ---- */
static void take_pair(kd_world *w, kd_component_id id, kd_entity source, uint32_t place, uint32_t events)
{
    ecs_relation *r = ecs_relation_of(w, id);
    ecs_run run = ecs_run_of(&r->targets, source.index);
    uint32_t item = run.base + run.skip + place;
    for (uint32_t event = KD_ON_REMOVE; event <= KD_ON_DESTROY; event *= 2)
        if (events & event)
            ecs_pair_event(w, (kd_event)event, source, id, r->targets.entities[item],
                           value_or_null(w, id, r, item));
    ecs_release_value(w, id, ecs_pair_value(w, id, r, item));
    ecs_pair_remove(w, r, source.index, place);
    w->cascade_count -= (w->components[id].desc->flags & KD_COMPONENT_CASCADE) != 0;
    ecs_relation_stamp(w, r);
}

void kd_unrelate_id(kd_world *w, kd_entity source, kd_component_id relation, kd_entity target)
{
    if (!kd_pair_find_id(w, source, relation, target))
        return;
    ecs_structure_changed(w, "kd_unrelate");
    source = living(w, source);
    uint32_t place = ecs_pair_place(ecs_relation_of(w, relation), source, living(w, target));
    take_pair(w, relation, source, place, KD_ON_REMOVE);
    ecs_events_settle(w);
}

static void take_targets(kd_world *w, kd_component_id id, kd_entity source, uint32_t events)
{
    while (ecs_run_of(&ecs_relation_of(w, id)->targets, source.index).count)
        take_pair(w, id, source, 0, events);
}

void ecs_relation_remove(kd_world *w, kd_component_id id, kd_entity source)
{
    if (!ecs_relation_find(w, id, source))
        return;
    ecs_structure_changed(w, "kd_remove");
    take_targets(w, id, source, KD_ON_REMOVE);
}

/* ---- deaths ---- */
static void take_sources(kd_world *w, kd_component_id id, kd_entity target)
{
    const ecs_relation *r = ecs_relation_of(w, id);
    ecs_run run = ecs_run_of(&r->sources, target.index);
    if (w->components[id].desc->flags & KD_COMPONENT_CASCADE)
        for (uint32_t i = 0; i < run.count; i++)
            w->doomed[w->doomed_count++] = r->sources.entities[run.base + i];
    for (uint32_t left = run.count; left-- > 0;) { /* the last one first: none has to move */
        kd_entity source = r->sources.entities[run.base + left];
        take_pair(w, id, source, ecs_pair_place(r, source, target), KD_ON_REMOVE);
    }
}

void ecs_relations_drop(kd_world *w, kd_entity e)
{
    for (uint32_t i = 0; i < w->relation_limit && i < w->relation_count; i++) {
        if (!w->relations[i].pair_count)
            continue;
        take_targets(w, w->relation_ids[i], e, KD_ON_REMOVE | KD_ON_DESTROY);
        take_sources(w, w->relation_ids[i], e);
    }
}

void ecs_relations_added(kd_world *w, kd_entity source)
{
    for (uint32_t i = 0; i < w->relation_limit && i < w->relation_count; i++) {
        kd_component_id id = w->relation_ids[i];
        kd_entities targets = kd_targets_id(w, source, id);
        for (uint32_t k = 0; k < targets.count; k++)
            ecs_pair_event(w, KD_ON_ADD, source, id, targets.at[k], NULL);
    }
}
