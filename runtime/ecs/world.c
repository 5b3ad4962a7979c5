/* The world as a whole: making, destroying, how much it holds. */

#include <stdlib.h>

#include "runtime/ecs/internal.h"

kd_world *kd_world_make(void)
{
    kd_world *w = aligned_alloc(64, (sizeof *w + 63) & ~(size_t)63);
    if (!w) {
        kd_fail(KD_NO_MEMORY, "world: no memory to make one (%zu bytes)", sizeof *w);
        return NULL;
    }
    memset(w, 0, sizeof *w);
    w->name_group_free = ECS_NONE;
    w->version = 1;
    w->last_change = "nothing";
    pthread_mutex_init(&w->lock, NULL);
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        w->commands[i].world = w;
        w->commands[i].worker = i;
    }
    if (!ecs_archetypes_init(w)) {
        kd_world_destroy(w);
        return NULL;
    }
    return w;
}

void kd_world_destroy(kd_world *w)
{
    if (!w)
        return;
    ecs_commands_fini(w);
    ecs_tables_fini(w); /* runs the hooks of every value */
    ecs_sides_fini(w);
    ecs_relations_fini(w);
    ecs_singletons_fini(w);
    ecs_queries_fini(w);
    ecs_observers_fini(w);
    ecs_names_fini(w);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++)
        ecs_free(w, w->components[id].spans);
    ecs_free(w, w->head.records);
    ecs_free(w, w->nodes);
    pthread_mutex_destroy(&w->lock);
    free(w);
}

size_t kd_world_bytes(const kd_world *w)
{
    return sizeof *w + atomic_load_explicit(&((kd_world *)(uintptr_t)w)->bytes, memory_order_relaxed);
}

void kd_world_limit_bytes(kd_world *w, size_t bytes)
{
    atomic_store_explicit(&w->refused, false, memory_order_relaxed);
    w->limit_bytes = bytes > sizeof *w ? bytes - sizeof *w : bytes ? 1 : 0;
}
