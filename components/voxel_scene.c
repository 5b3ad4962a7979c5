#include "components/voxel_scene.h"

#include "runtime/core/log.h"

KD_COMPONENT_DEFINE_FLAGS(kd_voxel_scene, "voxel_scene", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_voxel_scene, cascade_count, KD_U32, NULL, "nested grids in force"),
                          KD_FIELD(kd_voxel_scene, resolution, KD_U32, "voxels",
                                   "cells along an edge of every grid"),
                          KD_FIELD(kd_voxel_scene, span_m, KD_F32, "m", "edge of the finest voxels"),
                          KD_FIELD(kd_voxel_scene, cached_voxels, KD_U32, "voxels",
                                   "cached, over all primitives and spans"));

static void give(kd_ranges *ranges, uint32_t first, uint32_t count)
{
    if (!kd_ranges_give(ranges, first, count))
        kd_log(KD_LOG_WARNING, "out of memory: room of voxels that nothing needs stays taken");
}

void kd_voxel_cache_drop(kd_voxel_scene *scene, kd_voxel_cache *cache)
{
    for (uint32_t i = 0; i < cache->chunk_count; i++) {
        const kd_voxel_chunk *chunk = &scene->chunks[cache->first_chunk + i];
        give(&scene->voxel_places, chunk->first, chunk->count);
        if (chunk->first_binding != KD_EMPTY)
            give(&scene->binding_places, chunk->first_binding, chunk->count);
        scene->cached_voxels -= chunk->count;
    }
    give(&scene->chunk_places, cache->first_chunk, cache->chunk_count);
    cache->chunk_count = cache->voxel_count = 0;
}
