/* Which draws each shadow layer needs, on the CPU: one pass over the boxes of all draws a layer. The results
 * are indirect arguments in layer order and runs over them: one run for everything opaque, one for each
 * masked batch. */

#include "systems/shadow/internal.h"

#include <stdlib.h>

void *shadow_reserve(shadow_array *array, size_t bytes)
{
    if (bytes > array->capacity_bytes) {
        size_t capacity = bytes + bytes / 2;
        void *items = malloc(capacity);
        if (items == NULL)
            return NULL;
        free(array->items);
        *array = (shadow_array){items, capacity};
    }
    return array->items;
}

static bool batch_is(const kd_scene_store *store, const kd_draw_batch *batch, kd_alpha_mode mode)
{
    return store->materials[batch->material].desc.alpha_mode == mode;
}

/* Glass casts no shadow here; neither does what was told not to. */
static void find_casters(uint8_t *casters, kd_world *w, const kd_draw_list *list, const kd_scene_store *store)
{
    kd_component_id id = KD_ID(w, kd_mesh_instance);
    for (uint32_t b = 0; b < list->batch_count; b++) {
        const kd_draw_batch *batch = &list->batches[b];
        bool blended = batch_is(store, batch, KD_ALPHA_BLEND);
        for (uint32_t i = batch->first_draw; i < batch->first_draw + batch->draw_count; i++) {
            const kd_mesh_instance *instance = kd_find_id(w, list->draws[i].entity, id);
            casters[i] = !blended && !(instance != NULL && instance->no_shadow);
        }
    }
}

/* Append the batch's draws that touch the layer. */
static void append_batch(shadow_state *s, const kd_frustum *frustum, const kd_draw_list *list,
                         const kd_draw_batch *batch, kd_draw_indexed *args)
{
    const uint8_t *casters = s->casters.items;
    for (uint32_t i = batch->first_draw; i < batch->first_draw + batch->draw_count; i++) {
        const kd_draw *draw = &list->draws[i];
        if (casters[i] && kd_frustum_touches(frustum, draw->bounds_min_ws, draw->bounds_max_ws))
            args[s->arg_count++] = draw->args;
    }
}

static void close_run(shadow_state *s, shadow_layer *layer, uint32_t material, uint32_t first)
{
    if (s->arg_count == first)
        return;
    ((shadow_run *)s->runs.items)[s->run_count++] = (shadow_run){material, first, s->arg_count - first};
    layer->run_count++;
}

static void cull_layer(shadow_state *s, shadow_layer *layer, const kd_draw_list *list,
                       const kd_scene_store *store)
{
    kd_draw_indexed *args = s->args.items;
    kd_frustum frustum = kd_frustum_make(&layer->matrix, 0);
    layer->first_run = s->run_count;
    layer->run_count = 0;
    uint32_t first = s->arg_count;
    for (uint32_t b = 0; b < list->batch_count; b++)
        if (batch_is(store, &list->batches[b], KD_ALPHA_OPAQUE))
            append_batch(s, &frustum, list, &list->batches[b], args);
    close_run(s, layer, KD_NONE, first);
    for (uint32_t b = 0; b < list->batch_count; b++) {
        if (!batch_is(store, &list->batches[b], KD_ALPHA_MASK))
            continue;
        first = s->arg_count;
        append_batch(s, &frustum, list, &list->batches[b], args);
        close_run(s, layer, list->batches[b].material, first);
    }
}

kd_status shadow_cull(shadow_state *s, kd_world *w, const kd_draw_list *list, const kd_scene_store *store)
{
    s->arg_count = s->run_count = 0;
    if (s->layer_count == 0 || list->draw_count == 0) {
        for (uint32_t i = 0; i < s->layer_count; i++)
            s->layers[i].run_count = 0;
        return KD_OK;
    }
    size_t layers = s->layer_count;
    if (shadow_reserve(&s->casters, list->draw_count) == NULL ||
        shadow_reserve(&s->args, layers * list->draw_count * sizeof(kd_draw_indexed)) == NULL ||
        shadow_reserve(&s->runs, layers * (list->batch_count + 1) * sizeof(shadow_run)) == NULL) {
        s->layer_count = 0;
        return KD_NO_MEMORY;
    }
    find_casters(s->casters.items, w, list, store);
    for (uint32_t i = 0; i < s->layer_count; i++)
        cull_layer(s, &s->layers[i], list, store);
    return KD_OK;
}
