/* Handles: which are alive, and which index comes next. An index that was freed is given again with the next
 * generation, the one freed last first. */

#include "runtime/ecs/internal.h"

/* ---- asking ---- */
bool kd_alive(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    return ecs_locate(w, e, &t, &row);
}

kd_entity kd_entity_resolve(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    return ecs_locate(w, e, &t, &row) ? ecs_entities(t)[row] : KD_NO_ENTITY;
}

uint32_t kd_entity_count(const kd_world *w)
{
    return w->alive_count;
}

/* ---- giving and taking ---- */
bool ecs_handles_reserve(kd_world *w, uint32_t n)
{
    if (n <= w->free_count)
        return true;
    uint64_t need = (uint64_t)w->head.entity_limit + (n - w->free_count);
    return need <= ECS_ROW_MASK && ecs_reserve(w, &w->head.records, &w->record_capacity, w->head.entity_limit,
                                               (uint32_t)need, sizeof *w->head.records);
}

kd_entity ecs_handle_take(kd_world *w)
{
    w->alive_count++;
    if (!w->free_count)
        return (kd_entity){w->head.entity_limit++, 1};
    ecs_record r = w->head.records[w->free_first];
    kd_entity e = {w->free_first, ecs_record_next_generation(r)};
    w->free_first = ecs_record_row(r);
    w->free_count--;
    return e;
}

void ecs_handle_give(kd_world *w, kd_entity e)
{
    w->alive_count--;
    w->head.records[e.index] = ECS_DEAD;
    if (e.generation == ECS_MAX_GENERATION)
        return; /* all its handles were used: the index rests for ever */
    w->head.records[e.index] = ecs_record_make_free(w->free_first, e.generation + 1);
    w->free_first = e.index;
    w->free_count++;
}
