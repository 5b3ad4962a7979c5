/* Caches that a flying camera will need are made ahead, earliest first (Horn 1974: so all are in time if any
 * order is). The rate is the lowest that meets every date: the largest, over all dates, of the work until
 * then by the frames until then. */
#include "systems/voxel_cache/plan.h"

#include <math.h>
#include <stdlib.h>

#include "systems/voxel_cache/columns.h"

/* Work of a cache beside its columns, in columns: what dispatches and waits cost. */
#define CACHE_WORK 1000.0f

static int earlier(const void *left, const void *right)
{
    const plan_item *a = left, *b = right;
    if (a->due != b->due)
        return a->due < b->due ? -1 : 1;
    return (a->cache > b->cache) - (a->cache < b->cache);
}

static kd_status list_unmade(voxel_plan *plan, kd_voxel_scene *scene)
{
    plan->count = 0;
    if (plan->capacity < scene->unmade) {
        plan_item *grown = realloc(plan->items, scene->unmade * 2 * sizeof *grown);
        if (!grown)
            return KD_NO_MEMORY;
        plan->items = grown;
        plan->capacity = scene->unmade * 2;
    }
    for (uint32_t i = 0; i < scene->cache_count && plan->count < scene->unmade; i++) {
        kd_voxel_cache *c = &scene->caches[i];
        if (!c->alive || c->made)
            continue;
        if (!(c->work > 0))
            c->work = CACHE_WORK + columns_estimate(c->desc, c);
        plan->items[plan->count++] = (plan_item){.cache = i, .due = c->due, .work = c->work};
    }
    qsort(plan->items, plan->count, sizeof *plan->items, earlier);
    return KD_OK;
}

kd_status plan_choose(voxel_plan *plan, kd_voxel_scene *scene)
{
    kd_status status = list_unmade(plan, scene);
    float rate = 0, sum = 0, done = 0;
    for (uint32_t i = 0; i < plan->count; i++) {
        sum += plan->items[i].work;
        rate = fmaxf(rate, sum / (float)(plan->items[i].due ? plan->items[i].due : 1));
    }
    uint32_t chosen = 0;
    while (chosen < plan->count && (plan->items[chosen].due == 0 || done < rate))
        done += plan->items[chosen++].work;
    plan->count = chosen;
    return status;
}

void plan_fini(voxel_plan *plan)
{
    free(plan->items);
    *plan = (voxel_plan){0};
}
