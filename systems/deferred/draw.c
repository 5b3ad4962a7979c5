/* What drawing into the G-buffer and drawing blended surfaces have in common. */

#include "shaders/shared/bindings.h"
#include "systems/deferred/internal.h"

kd_gpu_geometry deferred_geometry(const kd_scene_store *store, const kd_draw_list *list)
{
    kd_gpu_buffer g = store->geometry, a = store->attributes;
    return (kd_gpu_geometry){
        .attributes = {{g, KD_LOC_POSITION, KD_ATTR_F32X3, 0, DEFERRED_GEOMETRY_STRIDE, false},
                       {g, KD_LOC_NORMAL, KD_ATTR_SNORM16X4, 12, DEFERRED_GEOMETRY_STRIDE, false},
                       {g, KD_LOC_TANGENT, KD_ATTR_SNORM16X4, 20, DEFERRED_GEOMETRY_STRIDE, false},
                       {a, KD_LOC_UV0, KD_ATTR_F32X2, 0, DEFERRED_ATTRIBUTE_STRIDE, false},
                       {a, KD_LOC_UV1, KD_ATTR_F32X2, 8, DEFERRED_ATTRIBUTE_STRIDE, false},
                       {a, KD_LOC_COLOR, KD_ATTR_UNORM8X4, 16, DEFERRED_ATTRIBUTE_STRIDE, false},
                       {list->object_ids, KD_LOC_OBJECT, KD_ATTR_U32X1, 0, 4, true}},
        .indices = store->indices,
    };
}

kd_gpu_geometry deferred_moving_geometry(const kd_scene_store *store, const kd_draw_list *list,
                                         kd_gpu_buffer previous)
{
    kd_gpu_geometry geometry = deferred_geometry(store, list);
    uint32_t count = 0;
    while (geometry.attributes[count].buffer.id)
        count++;
    geometry.attributes[count] =
        (kd_gpu_attribute){previous, KD_LOC_PREVIOUS, KD_ATTR_F32X3, 0, DEFERRED_GEOMETRY_STRIDE, false};
    return geometry;
}

kd_cull deferred_cull(const kd_draw_batch *batch, const kd_store_material *material)
{
    if (material->desc.double_sided)
        return KD_CULL_NONE;
    return batch->mirrored ? KD_CULL_FRONT : KD_CULL_BACK;
}

uint32_t deferred_map_bits(const kd_store_material *material)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 5; i++)
        bits |= material->maps[i].id != 0 ? 1u << i : 0;
    return bits;
}
