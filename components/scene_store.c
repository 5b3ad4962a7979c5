#include "components/scene_store.h"

static void release_store(void *value, void *user)
{
    kd_scene_store *store = value;
    (void)user;
    if (store->release)
        store->release(store);
}

static const kd_field store_fields[] = {
    KD_FIELD(kd_scene_store, model_count, KD_U32, NULL, "models"),
    KD_FIELD(kd_scene_store, mesh_count, KD_U32, NULL, "meshes"),
    KD_FIELD(kd_scene_store, primitive_count, KD_U32, NULL, "primitives of all meshes"),
    KD_FIELD(kd_scene_store, material_count, KD_U32, NULL, "materials"),
    KD_FIELD(kd_scene_store, skin_count, KD_U32, NULL, "skins"),
    KD_FIELD(kd_scene_store, clip_count, KD_U32, NULL, "animation clips"),
    KD_FIELD(kd_scene_store, deformed_count, KD_U32, NULL, "instances with vertices of their own"),
    KD_FIELD(kd_scene_store, vertex_count, KD_U32, NULL, "vertices reserved in the geometry stream"),
    KD_FIELD(kd_scene_store, index_count, KD_U32, NULL, "indices reserved"),
    KD_FIELD(kd_scene_store, revision, KD_U32, NULL, "raised whenever meshes or materials were added"),
};
const kd_component_desc kd_scene_store_desc = {.name = "scene_store",
                                               .size = (uint32_t)sizeof(kd_scene_store),
                                               .align = (uint32_t) _Alignof(kd_scene_store),
                                               .fields = store_fields,
                                               .field_count =
                                                   (uint32_t)(sizeof store_fields / sizeof *store_fields),
                                               .on_remove = release_store};

static void release_list(void *value, void *user)
{
    kd_draw_list *list = value;
    (void)user;
    if (list->release)
        list->release(list);
}

static const kd_field list_fields[] = {
    KD_FIELD(kd_draw_list, draw_count, KD_U32, NULL, "draws of this frame"),
    KD_FIELD(kd_draw_list, batch_count, KD_U32, NULL, "runs of draws that share a material"),
    KD_FIELD(kd_draw_list, object_count, KD_U32, NULL, "objects of this frame"),
    KD_FIELD(kd_draw_list, bounds_min_ws, KD_VEC3, "m", "low corner of everything drawn"),
    KD_FIELD(kd_draw_list, bounds_max_ws, KD_VEC3, "m", "high corner of everything drawn"),
};
const kd_component_desc kd_draw_list_desc = {.name = "draw_list",
                                             .size = (uint32_t)sizeof(kd_draw_list),
                                             .align = (uint32_t) _Alignof(kd_draw_list),
                                             .fields = list_fields,
                                             .field_count =
                                                 (uint32_t)(sizeof list_fields / sizeof *list_fields),
                                             .on_remove = release_list};
