#ifndef KD_SYSTEMS_SCENE_SCENE_H
#define KD_SYSTEMS_SCENE_SCENE_H

/* Brings models into a world: registers their meshes, materials, skins and clips with the scene store and makes an entity
 * for every node. CPU only; system scene_upload takes what is new to the GPU at the start of the next frame. */

#include "components/scene_store.h"
#include "runtime/ecs/system.h"

/** Register a model with the store; the store takes it over (kd_model_destroy at the end). Returns its number in `out`. */
kd_status kd_scene_add_model(kd_world *w, kd_model *model, uint32_t *out);

/** Make entities for all nodes of a registered model below one new root entity (parent may be KD_NO_ENTITY).
 *  The root carries kd_transform, kd_world_transform, kd_animation when the model has clips; nodes carry their parts: kd_mesh_instance,
 *  kd_skin_instance, kd_morph_weights, kd_light, kd_camera, name. */
kd_status kd_scene_instantiate(kd_world *w, uint32_t model, kd_entity parent, const char *name, kd_entity *root);

/** Add a material to the store; returns its number. */
uint32_t kd_scene_add_material(kd_world *w, const kd_material_desc *desc);

/** Give every mesh below `root` the material (kd_mesh_instance.material). */
void kd_scene_override_material(kd_world *w, kd_entity root, uint32_t material);

/** Play a clip of the instance by name, blending from the one that runs. Errors KD_NOT_FOUND, the message lists the clips. */
kd_status kd_scene_play(kd_world *w, kd_entity root, const char *clip, bool loop, float speed, float blend_s);

/** Register systems scene_upload and draw_list. */
kd_status kd_scene_import(kd_schedule *s);

#endif
