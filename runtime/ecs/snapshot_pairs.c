/* Relating as the lists of a snapshot say, which may say anything. First everything is checked and the
 * sources of each target are counted; then both directions are made in their final size and filled. */

#include "runtime/ecs/internal.h"
#include "runtime/ecs/snapshot_format.h"

typedef struct relating {
    kd_world *w;
    kd_component_id id;
    ecs_relation *r;
    const snapshot_pairs *pairs;
    uint32_t *seen;   /* by entity index: number of the source that named it last */
    uint32_t *counts; /* by entity index: sources it has */
} relating;

static uint32_t u32_at(const uint8_t *list, uint32_t i)
{
    uint32_t value;
    memcpy(&value, list + (size_t)i * sizeof value, sizeof value);
    return value;
}

static kd_entity entity_at(const uint8_t *list, uint32_t i)
{
    kd_entity e;
    memcpy(&e, list + (size_t)i * sizeof e, sizeof e);
    return e;
}

static bool is_living(const kd_world *w, kd_entity e)
{
    return e.index < w->head.entity_limit && e.generation &&
           ecs_record_generation(w->head.records[e.index]) == e.generation;
}

static bool targets_are_sane(relating *in, uint32_t source, uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        kd_entity target = entity_at(in->pairs->targets, i);
        if (!is_living(in->w, target) || in->seen[target.index] == source + 1)
            return false;
        in->seen[target.index] = source + 1;
        in->counts[target.index]++;
    }
    return true;
}

static bool sources_are_sane(relating *in)
{
    const snapshot_pairs *p = in->pairs;
    bool exclusive = in->w->components[in->id].desc->flags & KD_COMPONENT_EXCLUSIVE;
    uint32_t first = 0;
    for (uint32_t s = 0; s < p->source_count; s++) {
        uint32_t count = u32_at(p->counts, s);
        bool ascends = !s || entity_at(p->sources, s).index > entity_at(p->sources, s - 1).index;
        if (!count || count > p->pair_count - first || (exclusive && count > 1) || !ascends ||
            !is_living(in->w, entity_at(p->sources, s)) || !targets_are_sane(in, s, first, count))
            return false;
        first += count;
    }
    return first == p->pair_count;
}

static bool make_runs(relating *in)
{
    const snapshot_pairs *p = in->pairs;
    for (uint32_t s = 0; s < p->source_count; s++)
        if (!ecs_run_make(in->w, &in->r->targets, entity_at(p->sources, s).index, u32_at(p->counts, s)))
            return false;
    for (uint32_t index = 0; index < in->w->head.entity_limit; index++)
        if (in->counts[index] && !ecs_run_make(in->w, &in->r->sources, index, in->counts[index]))
            return false;
    return ecs_doomed_reserve(in->w, in->id, p->pair_count);
}

static void fill_targets(relating *in)
{
    const snapshot_pairs *p = in->pairs;
    ecs_store *to = &in->r->targets;
    size_t first = 0;
    for (uint32_t s = 0; s < p->source_count; s++) {
        ecs_run run = ecs_run_of(to, entity_at(p->sources, s).index);
        memcpy(to->entities + run.base, p->targets + first * sizeof *to->entities,
               run.count * sizeof *to->entities);
        memcpy(to->places + run.base, p->places + first * sizeof *to->places, run.count * sizeof *to->places);
        if (to->value_size)
            memcpy(to->values + (size_t)run.base * to->value_size, p->values + first * to->value_size,
                   (size_t)run.count * to->value_size);
        first += run.count;
    }
}

/* Every place among a target's sources is taken once. */
static bool fill_sources(relating *in)
{
    const snapshot_pairs *p = in->pairs;
    for (uint32_t s = 0, i = 0; s < p->source_count; s++)
        for (uint32_t left = u32_at(p->counts, s); left > 0; left--, i++) {
            ecs_run run = ecs_run_of(&in->r->sources, entity_at(p->targets, i).index);
            uint32_t place = u32_at(p->places, i);
            if (place >= run.count || in->r->sources.entities[run.base + place].generation)
                return false;
            in->r->sources.entities[run.base + place] = entity_at(p->sources, s);
        }
    return true;
}

static kd_status relate(relating *in)
{
    if (!sources_are_sane(in))
        return KD_BAD_FORMAT;
    if (!make_runs(in))
        return KD_NO_MEMORY;
    fill_targets(in);
    if (!fill_sources(in))
        return KD_BAD_FORMAT;
    in->r->pair_count = in->pairs->pair_count;
    in->w->pair_count += in->pairs->pair_count;
    if (in->w->components[in->id].desc->flags & KD_COMPONENT_CASCADE)
        in->w->cascade_count += in->pairs->pair_count;
    ecs_relation_stamp(in->w, in->r);
    return KD_OK;
}

kd_status snapshot_relate(struct kd_world *w, uint32_t component, const snapshot_pairs *pairs)
{
    relating in = {.w = w, .id = component, .pairs = pairs, .r = ecs_relation_ensure(w, component)};
    size_t bytes = (size_t)w->head.entity_limit * sizeof(uint32_t);
    in.seen = ecs_grow(w, NULL, 0, bytes);
    in.counts = ecs_grow(w, NULL, 0, bytes);
    bool room = in.r && in.seen && in.counts;
    if (room) {
        memset(in.seen, 0, bytes);
        memset(in.counts, 0, bytes);
    }
    kd_status status = room ? relate(&in) : KD_NO_MEMORY;
    ecs_free(w, in.seen);
    ecs_free(w, in.counts);
    return status;
}
