/* The store of one relation: for every source a run of targets, for every target a run of sources. All runs
 * of one direction lie in one pool, in blocks of powers of two that are given again by size; a page table by
 * entity index says where an entity's run is.
 *
 * A pair stands in both directions, and the source's side notes at which place the target's side has it.
 * Targets keep their order: a gap is closed from the nearer end, and what that frees at the front is skipped.
 * Sources are many where a target is popular, so there the last one fills the gap, and one place elsewhere is
 * corrected. */

#include "runtime/ecs/internal.h"

#define KEPT_ITEMS 4096u /* a pool up to this long is kept when the last pair goes */

/* ---- runs ---- */
static ecs_run *run_at(const ecs_store *s, uint32_t index)
{
    return &s->pages[index / ECS_RUN_PAGE][index % ECS_RUN_PAGE];
}

static bool page_reserve(kd_world *w, ecs_store *s, uint32_t index)
{
    uint32_t page = index / ECS_RUN_PAGE, limit = s->page_limit;
    if (page >= limit) {
        if (!ecs_reserve(w, &s->pages, &s->page_limit, limit, page + 1, sizeof *s->pages))
            return false;
        memset(s->pages + limit, 0, (s->page_limit - limit) * sizeof *s->pages);
    }
    if (s->pages[page])
        return true;
    s->pages[page] = ecs_grow(w, NULL, 0, ECS_RUN_PAGE * sizeof **s->pages);
    if (s->pages[page])
        memset(s->pages[page], 0, ECS_RUN_PAGE * sizeof **s->pages);
    return s->pages[page] != NULL;
}

/* Make one array of the pool as long as the others will be. */
static bool array_grow(kd_world *w, void *array_pointer, const ecs_store *s, uint32_t capacity, size_t size)
{
    void *array;
    memcpy(&array, array_pointer, sizeof array);
    array = size ? ecs_grow(w, array, s->used * size, capacity * size) : array;
    if (size && array)
        memcpy(array_pointer, &array, sizeof array);
    return !size || array;
}

static bool pool_reserve(kd_world *w, ecs_store *s, uint32_t items)
{
    if (items <= s->capacity - s->used)
        return true;
    if (items > ECS_MAX_ITEMS - s->used)
        return false;
    uint32_t capacity = ecs_next_capacity(s->capacity, s->used + items);
    if (!array_grow(w, &s->entities, s, capacity, sizeof *s->entities) ||
        !array_grow(w, &s->places, s, capacity, s->has_places ? sizeof *s->places : 0) ||
        !array_grow(w, &s->values, s, capacity, s->value_size))
        return false;
    s->capacity = capacity;
    return true;
}

static bool block_take(kd_world *w, ecs_store *s, uint32_t room, uint32_t *base)
{
    if (s->free[room]) {
        *base = s->free[room] - 1;
        s->free[room] = s->entities[*base].index;
        return true;
    }
    if (!pool_reserve(w, s, 1u << room))
        return false;
    *base = s->used;
    s->used += 1u << room;
    return true;
}

static void block_give(ecs_store *s, ecs_run *run)
{
    if (!run->room)
        return;
    s->entities[run->base].index = s->free[run->room - 1];
    s->free[run->room - 1] = run->base + 1;
    *run = (ecs_run){0};
}

static void items_move(ecs_store *s, uint32_t to, uint32_t from, uint32_t count)
{
    memmove(s->entities + to, s->entities + from, count * sizeof *s->entities);
    if (s->has_places)
        memmove(s->places + to, s->places + from, count * sizeof *s->places);
    if (s->value_size)
        memmove(s->values + (size_t)to * s->value_size, s->values + (size_t)from * s->value_size,
                (size_t)count * s->value_size);
}

/* Make room for one more item at the end of an entity's run. */
static bool run_reserve(kd_world *w, ecs_store *s, uint32_t index)
{
    if (!page_reserve(w, s, index))
        return false;
    ecs_run *run = run_at(s, index);
    uint32_t held = run->room ? 1u << (run->room - 1) : 0, base;
    if (run->skip + run->count < held)
        return true;
    if (run->skip && run->skip >= held / 2) {
        items_move(s, run->base, run->base + run->skip, run->count);
        run->skip = 0;
        return true;
    }
    if (!block_take(w, s, run->room, &base)) /* twice as many as now; one when there are none */
        return false;
    ecs_run grown = {.base = base, .count = run->count, .room = (run->room + 1u) & 31u};
    items_move(s, base, run->base + run->skip, run->count);
    block_give(s, run);
    *run = grown;
    return true;
}

static uint32_t run_append(ecs_store *s, uint32_t index, kd_entity e)
{
    ecs_run *run = run_at(s, index);
    s->entities[run->base + run->skip + run->count] = e;
    return run->count++;
}

static uint32_t search(const ecs_store *s, ecs_run run, kd_entity e)
{
    const kd_entity *at = s->entities + run.base + run.skip;
    for (uint32_t low = 0, high = run.count; low < high; low++) { /* from both ends: deaths come in order */
        if (kd_entity_equal(at[low], e))
            return low;
        if (kd_entity_equal(at[--high], e))
            return high;
    }
    return ECS_NONE;
}

static void store_fini(kd_world *w, ecs_store *s)
{
    for (uint32_t page = 0; page < s->page_limit; page++)
        ecs_free(w, s->pages[page]);
    ecs_free(w, s->pages);
    ecs_free(w, s->entities);
    ecs_free(w, s->places);
    ecs_free(w, s->values);
    *s = (ecs_store){.value_size = s->value_size, .has_places = s->has_places};
}

/* No run has an item: begin the pool anew, or give it back when it grew large. */
static void store_clear(kd_world *w, ecs_store *s)
{
    if (s->capacity > KEPT_ITEMS)
        store_fini(w, s);
    s->used = 0;
    memset(s->free, 0, sizeof s->free);
}

bool ecs_run_make(kd_world *w, ecs_store *s, uint32_t index, uint32_t count)
{
    uint32_t room = 0, base;
    while (1u << room < count)
        room++;
    if (!page_reserve(w, s, index) || !block_take(w, s, room, &base))
        return false;
    *run_at(s, index) = (ecs_run){.base = base, .count = count & ECS_ROW_MASK, .room = (room + 1) & 31u};
    memset(s->entities + base, 0, count * sizeof *s->entities);
    return true;
}

/* ---- pairs ---- */
ecs_relation *ecs_relation_ensure(kd_world *w, kd_component_id id)
{
    uint32_t place = w->components[id].relation, limit = w->relation_limit;
    if (place > limit) {
        if (!ecs_reserve(w, &w->relations, &w->relation_capacity, limit, place, sizeof *w->relations))
            return NULL;
        memset(w->relations + limit, 0, (w->relation_capacity - limit) * sizeof *w->relations);
        w->relation_limit = w->relation_capacity;
    }
    ecs_relation *r = &w->relations[place - 1];
    r->targets.has_places = true;
    r->targets.value_size = w->components[id].size;
    return r;
}

uint32_t ecs_pair_place(const ecs_relation *r, kd_entity source, kd_entity target)
{
    ecs_run targets = ecs_run_of(&r->targets, source.index);
    if (!targets.count)
        return ECS_NONE;
    ecs_run sources = ecs_run_of(&r->sources, target.index);
    if (sources.count < targets.count && search(&r->sources, sources, source) == ECS_NONE)
        return ECS_NONE;
    return search(&r->targets, targets, target);
}

bool ecs_pair_reserve(kd_world *w, ecs_relation *r, uint32_t source, uint32_t target)
{
    bool done = run_reserve(w, &r->targets, source) && run_reserve(w, &r->sources, target);
    if (!done && ecs_run_of(&r->targets, source).room && !ecs_run_of(&r->targets, source).count)
        block_give(&r->targets, run_at(&r->targets, source));
    return done;
}

uint32_t ecs_pair_add(kd_world *w, ecs_relation *r, kd_entity source, kd_entity target)
{
    uint32_t place = run_append(&r->targets, source.index, target);
    ecs_run run = ecs_run_of(&r->targets, source.index);
    uint32_t item = run.base + run.skip + place;
    r->targets.places[item] = run_append(&r->sources, target.index, source);
    r->pair_count++;
    w->pair_count++;
    return item;
}

/* Take the source that stands at `place` off the target's run; the last one comes there. */
static void source_unlink(ecs_relation *r, kd_entity target, uint32_t place)
{
    ecs_run *run = run_at(&r->sources, target.index);
    uint32_t last = --run->count;
    if (place != last) {
        kd_entity moved = r->sources.entities[run->base + place] = r->sources.entities[run->base + last];
        ecs_run other = ecs_run_of(&r->targets, moved.index);
        r->targets.places[other.base + other.skip + search(&r->targets, other, target)] = place;
    }
    if (!run->count)
        block_give(&r->sources, run);
}

bool ecs_pair_retarget(kd_world *w, ecs_relation *r, kd_entity source, uint32_t item, kd_entity target)
{
    if (!run_reserve(w, &r->sources, target.index))
        return false;
    source_unlink(r, r->targets.entities[item], r->targets.places[item]);
    r->targets.entities[item] = target;
    r->targets.places[item] = run_append(&r->sources, target.index, source);
    return true;
}

void ecs_pair_remove(kd_world *w, ecs_relation *r, uint32_t source, uint32_t place)
{
    ecs_run *run = run_at(&r->targets, source);
    uint32_t first = run->base + run->skip, item = first + place;
    source_unlink(r, r->targets.entities[item], r->targets.places[item]);
    run->count--;
    if (place < run->count / 2) {
        items_move(&r->targets, first + 1, first, place);
        run->skip++;
    } else {
        items_move(&r->targets, item, item + 1, run->count - place);
    }
    if (!run->count)
        block_give(&r->targets, run);
    w->pair_count--;
    if (--r->pair_count)
        return;
    store_clear(w, &r->targets);
    store_clear(w, &r->sources);
}

void ecs_relations_fini(kd_world *w)
{
    for (uint32_t i = 0; i < w->relation_limit && i < w->relation_count; i++) {
        ecs_relation *r = &w->relations[i];
        for (uint32_t index = 0; r->pair_count && index < r->targets.page_limit * ECS_RUN_PAGE; index++) {
            ecs_run run = ecs_run_of(&r->targets, index);
            for (uint32_t k = 0; k < run.count; k++)
                ecs_release_value(w, w->relation_ids[i],
                                  ecs_pair_value(w, w->relation_ids[i], r, run.base + run.skip + k));
        }
        store_fini(w, &r->targets);
        store_fini(w, &r->sources);
    }
    ecs_free(w, w->relations);
    ecs_free(w, w->doomed);
}
