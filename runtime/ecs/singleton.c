/* Values that belong to the world itself, one of a kind. Their address never changes. */

#include "runtime/ecs/internal.h"

void *kd_singleton_find(const kd_world *w, kd_component_id id)
{
    return id && id <= kd_component_count(w)
               ? atomic_load_explicit(&((kd_world *)(uintptr_t)w)->components[id].singleton,
                                      memory_order_acquire)
               : NULL;
}

void *kd_singleton_ensure(kd_world *w, const kd_component_desc *desc)
{
    kd_component_id id = kd_component_ensure(w, desc);
    if (!id)
        return NULL;
    ecs_watch_value(w, id, false);
    ecs_component *c = &w->components[id];
    void *value = atomic_load_explicit(&c->singleton, memory_order_acquire);
    if (value)
        return value;
    pthread_mutex_lock(&w->lock);
    value = atomic_load_explicit(&c->singleton, memory_order_relaxed);
    if (!value) {
        value = ecs_grow(w, NULL, 0, c->size ? c->size : 1);
        if (value) {
            ecs_write_value(w, id, value, NULL);
            atomic_store_explicit(&c->singleton, value, memory_order_release);
        }
    }
    pthread_mutex_unlock(&w->lock);
    return value;
}

/* In reverse order of registration: what was registered first may be used by what came later. */
void ecs_singletons_fini(kd_world *w)
{
    for (kd_component_id id = kd_component_count(w); id; id--) {
        void *value = atomic_load_explicit(&w->components[id].singleton, memory_order_relaxed);
        if (value)
            ecs_release_value(w, id, value);
        ecs_free(w, value);
    }
}
