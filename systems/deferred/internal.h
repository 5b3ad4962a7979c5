#ifndef KD_SYSTEMS_DEFERRED_INTERNAL_H
#define KD_SYSTEMS_DEFERRED_INTERNAL_H

#include "components/material.h"
#include "components/scene_store.h"
#include "shaders/shared/scene.h"

enum { DEFERRED_GEOMETRY_STRIDE = KD_GEOMETRY_WORDS * 4, DEFERRED_ATTRIBUTE_STRIDE = KD_ATTRIBUTE_WORDS * 4 };

/** All streams of a drawn vertex. */
kd_gpu_geometry deferred_geometry(const kd_scene_store *store, const kd_draw_list *list);
/** The same, and where the vertices were a frame ago. */
kd_gpu_geometry deferred_moving_geometry(const kd_scene_store *store, const kd_draw_list *list,
                                         kd_gpu_buffer previous);
/** Which faces of a batch are left out. */
kd_cull deferred_cull(const kd_draw_batch *batch, const kd_store_material *material);
/** The KD_MAP_* bits of the maps that are there. */
uint32_t deferred_map_bits(const kd_store_material *material);

static inline bool deferred_is_blended(const kd_scene_store *store, const kd_draw_batch *batch)
{
    return store->materials[batch->material].desc.alpha_mode == KD_ALPHA_BLEND;
}

#endif
