/* Observers and the queue of what they will be told. A change puts events into the queue; the outermost call
 * empties it when the change is complete. Two queues take turns: one is read while the other receives what
 * the observers themselves raise, so that values in the first stay where they are. */

#include "runtime/ecs/observer.h"
#include "runtime/ecs/internal.h"

/* Close the gaps that those who left have kept. */
static void pack_observers(kd_world *w)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < w->observer_count; i++)
        if (w->observers[i].fn)
            w->observers[count++] = w->observers[i];
    w->observer_count = count;
}

kd_status kd_observe(kd_world *w, const kd_component_desc *desc, uint32_t events, kd_observer_fn *fn,
                     void *user)
{
    kd_component_id id = kd_component_ensure(w, desc);
    if (!w->event_hold)
        pack_observers(w);
    if (!id || !ecs_reserve(w, &w->observers, &w->observer_capacity, w->observer_count, w->observer_count + 1,
                            sizeof *w->observers))
        return KD_NO_MEMORY;
    w->observers[w->observer_count++] = (ecs_observer){id, events, fn, user};
    w->observed[id] |= (uint8_t)events;
    w->any_observed = true;
    for (uint32_t i = 0; i < w->archetype_count; i++)
        ecs_archetype_observe(w, w->archetypes[i]);
    return KD_OK;
}

void kd_unobserve(kd_world *w, const kd_component_desc *desc, kd_observer_fn *fn, void *user)
{
    kd_component_id id = kd_component_ensure(w, desc);
    uint8_t left = 0;
    for (uint32_t i = 0; i < w->observer_count; i++) {
        ecs_observer *o = &w->observers[i];
        if (o->id == id && o->fn == fn && o->user == user)
            o->fn = NULL; /* its place stays: the list may just be walked */
        if (o->id == id && o->fn)
            left |= (uint8_t)o->events;
    }
    w->observed[id] = left;
    for (uint32_t i = 0; i < w->archetype_count; i++)
        ecs_archetype_observe(w, w->archetypes[i]);
}

void ecs_archetype_observe(const kd_world *w, ecs_archetype *a)
{
    a->observed = false;
    for (uint32_t i = 0; i < a->id_count; i++)
        a->observed |= w->observed[a->ids[i]] != 0;
}

/* ---- raising ---- */
static bool queue_reserve(kd_world *w, ecs_event_queue *q, kd_component_id id, uint32_t units)
{
    if (units <= UINT32_MAX - q->unit_count &&
        ecs_reserve(w, &q->events, &q->capacity, q->count, q->count + 1, sizeof *q->events) &&
        ecs_reserve(w, &q->units, &q->unit_capacity, q->unit_count, q->unit_count + units, 16))
        return true;
    kd_fail(KD_NO_MEMORY, "component %s: an observer misses an event, memory is out",
            w->components[id].desc->name);
    return false;
}

void ecs_event_queue_add(kd_world *w, kd_event event, kd_entity e, kd_component_id id, const void *value)
{
    ecs_event_queue *q = &w->events[w->event_turn];
    uint32_t size = value ? (w->components[id].size + 15) / 16 : 0;
    if (!queue_reserve(w, q, id, size))
        return;
    q->events[q->count++] = (ecs_queued){event, id, e, size ? q->unit_count : ECS_NONE};
    if (size)
        memcpy(q->units + (size_t)q->unit_count * 16, value, w->components[id].size);
    q->unit_count += size;
}

/* The target goes before the value. */
void ecs_pair_event_queue_add(kd_world *w, kd_event event, kd_entity source, kd_component_id id,
                              kd_entity target, const void *value)
{
    ecs_event_queue *q = &w->events[w->event_turn];
    uint32_t size = value ? (w->components[id].size + 15) / 16 : 0;
    if (!queue_reserve(w, q, id, size + 1))
        return;
    uint8_t *units = q->units + (size_t)q->unit_count * 16;
    q->events[q->count++] = (ecs_queued){event, id, source, q->unit_count};
    memcpy(units, &target, sizeof target);
    memcpy(units + sizeof target, &(uint64_t){value != NULL}, sizeof(uint64_t));
    if (value)
        memcpy(units + 16, value, w->components[id].size);
    q->unit_count += size + 1;
}

/* All observed components of a row have come, or go. */
void ecs_event_row(kd_world *w, uint32_t events, const ecs_table *t, uint32_t row)
{
    const ecs_archetype *a = t->archetype;
    kd_entity e = ecs_entities(t)[row];
    for (uint32_t i = 0; i < a->id_count && a->observed; i++) {
        uint32_t c = a->column_of[a->ids[i]];
        const void *value =
            c == ECS_TAG_COLUMN ? NULL : t->columns[c].data + (size_t)row * t->columns[c].size;
        for (uint32_t event = KD_ON_ADD; event <= KD_ON_DESTROY; event *= 2)
            if (events & event)
                ecs_event(w, (kd_event)event, e, a->ids[i], event >= KD_ON_REMOVE ? value : NULL);
    }
    for (uint32_t i = 0; i < w->side_limit && i < w->side_count; i++) {
        kd_component_id id = w->side_ids[i];
        const void *value =
            w->components[id].sparse && w->observed[id] ? ecs_side_find(w, id, e.index) : NULL;
        for (uint32_t event = KD_ON_ADD; event <= KD_ON_DESTROY && value; event *= 2)
            if (events & event)
                ecs_event(w, (kd_event)event, e, id,
                          event >= KD_ON_REMOVE && w->components[id].size ? value : NULL);
    }
}

/* ---- telling ---- */
static void read_pair(kd_observed *what)
{
    const uint8_t *units = what->value;
    uint64_t with_value;
    memcpy(&what->target, units, sizeof what->target);
    memcpy(&with_value, units + sizeof what->target, sizeof with_value);
    what->value = with_value ? units + 16 : NULL;
}

static void tell(kd_world *w, const ecs_event_queue *q, const ecs_queued *event)
{
    kd_observed what = {.event = (kd_event)event->event,
                        .entity = event->entity,
                        .component = w->components[event->id].desc,
                        .value = event->value == ECS_NONE ? NULL : q->units + (size_t)event->value * 16};
    if (w->components[event->id].relation)
        read_pair(&what);
    for (uint32_t i = 0; i < w->observer_count; i++) {
        ecs_observer o = w->observers[i]; /* the array may move in the call */
        if (o.id == event->id && o.events & event->event && o.fn)
            o.fn(w, &what, o.user);
    }
}

static bool give_up(kd_world *w, ecs_event_queue *q)
{
    kd_fail(KD_TOO_LARGE, "component %s: its observers raise events without end; %u are dropped",
            w->components[q->events[0].id].desc->name, q->count);
    q->count = q->unit_count = 0;
    return true;
}

void ecs_events_tell(kd_world *w)
{
    if (w->event_hold)
        return;
    w->event_hold++;
    for (uint32_t round = 0; w->events[w->event_turn].count; round++) {
        ecs_event_queue *q = &w->events[w->event_turn];
        if (round == KD_MAX_EVENT_ROUNDS && give_up(w, q))
            break;
        w->event_turn ^= 1;
        for (uint32_t i = 0; i < q->count; i++)
            tell(w, q, &q->events[i]);
        q->count = q->unit_count = 0;
    }
    w->event_hold--;
}

void ecs_observers_fini(kd_world *w)
{
    for (int i = 0; i < 2; i++) {
        ecs_free(w, w->events[i].events);
        ecs_free(w, w->events[i].units);
    }
    ecs_free(w, w->observers);
}
