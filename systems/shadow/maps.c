/* Shadow maps and what they hold. A map is drawn only when its matrix or its casters differ from what it was
 * drawn from. Where nothing but moving casters differ, the depth of the resting ones comes from a second map
 * by a copy: depth is the nearest of all, so that the order in which casters come does not show. */

#include "systems/shadow/internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- textures ---- */

bool shadow_maps_ensure(kd_gpu *gpu, shadow_maps *maps, uint32_t layers, uint32_t edge, const char *name)
{
    layers = layers > 0 ? layers : 1; /* there is always a layer, so that shaders can bind the texture */
    if (layers <= maps->layers && edge == maps->edge)
        return false;
    shadow_maps_destroy(gpu, maps);
    maps->layers = layers;
    maps->edge = edge;
    maps->texture = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_2D_ARRAY,
                                                                    .format = KD_DEPTH32F,
                                                                    .width = edge,
                                                                    .height = edge,
                                                                    .depth = layers,
                                                                    .filter = KD_NEAREST,
                                                                    .name = name});
    for (uint32_t i = 0; i < layers; i++)
        maps->targets[i] =
            kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.depth = maps->texture, .layer = i, .name = name});
    return true;
}

void shadow_maps_destroy(kd_gpu *gpu, shadow_maps *maps)
{
    for (uint32_t i = 0; i < maps->layers; i++)
        kd_gpu_destroy_target(gpu, maps->targets[i]);
    kd_gpu_destroy_texture(gpu, maps->texture);
    *maps = (shadow_maps){0};
}

/* ---- contents ---- */

shadow_kept *shadow_kept_of(shadow_state *s, const shadow_layer *layer)
{
    return &s->kept[(layer->directional ? 0 : SHADOW_DIRECTIONAL_MATRICES) + layer->layer];
}

static bool are_equal(const shadow_caster *a, const shadow_caster *b, uint32_t count)
{
    return count == 0 || memcmp(a, b, count * sizeof *a) == 0;
}

shadow_work shadow_compare(const shadow_state *s, const shadow_layer *layer)
{
    const shadow_kept *kept = &s->kept[(layer->directional ? 0 : SHADOW_DIRECTIONAL_MATRICES) + layer->layer];
    const shadow_caster *now = (const shadow_caster *)s->casters.items + layer->first_arg,
                        *held = kept->casters.items;
    if (!kept->valid || memcmp(&kept->matrix, &layer->matrix, sizeof layer->matrix) != 0 ||
        kept->resting != layer->resting || !are_equal(now, held, layer->resting))
        return SHADOW_DRAW_ALL;
    if (kept->moving == layer->moving &&
        are_equal(now + layer->resting, held + layer->resting, layer->moving))
        return SHADOW_KEEP;
    return layer->resting > 0 ? SHADOW_DRAW_MOVING : SHADOW_DRAW_ALL;
}

void shadow_remember(shadow_state *s, const shadow_layer *layer)
{
    shadow_kept *kept = shadow_kept_of(s, layer);
    size_t bytes = ((size_t)layer->resting + layer->moving) * sizeof(shadow_caster);
    kept->matrix = layer->matrix;
    kept->resting = layer->resting;
    kept->moving = layer->moving;
    kept->valid = bytes == 0 || shadow_reserve(&kept->casters, bytes) != NULL; /* without: drawn again */
    if (kept->valid && bytes > 0)
        memcpy(kept->casters.items, (const shadow_caster *)s->casters.items + layer->first_arg, bytes);
}

void shadow_forget(shadow_state *s, bool directional)
{
    uint32_t first = directional ? 0 : SHADOW_DIRECTIONAL_MATRICES;
    uint32_t end = directional ? SHADOW_DIRECTIONAL_MATRICES : SHADOW_MAX_LAYERS;
    for (uint32_t i = first; i < end; i++)
        s->kept[i].valid = s->kept[i].resting_valid = false;
}
