#ifndef KD_SYSTEMS_SCENE_SCENE_H
#define KD_SYSTEMS_SCENE_SCENE_H

/* Brings models into a world: registers their meshes, materials, skins and clips with the scene store and
 * makes an entity for every node. CPU only; system scene_upload takes what is new to the GPU in phase
 * animate, so that what a script has spawned is seen in the same frame. */

#include "components/scene_store.h"
#include "runtime/ecs/system.h"

/** Register a model with the store.
 *
 *  Returns its number in `out`
 *  Errors  KD_NO_MEMORY, KD_TOO_LARGE; the store is then unchanged and the model still the caller's
 *  Owns    the store takes the model over (kd_model_destroy with the world)
 */
kd_status kd_scene_add_model(kd_world *w, kd_model *model, uint32_t *out);

/** Make entities for all nodes of a registered model below one new root entity (parent may be KD_NO_ENTITY).
 *  The root carries kd_transform, kd_world_transform, kd_animation when the model has clips; nodes carry
 *  their parts: kd_mesh_instance, kd_skin_instance, kd_morph_weights, kd_light, kd_camera, name. The first
 *  clip plays, looped, until kd_scene_play or kd_animation.clip = 0 says otherwise. */
kd_status kd_scene_instantiate(kd_world *w, uint32_t model, kd_entity parent, const char *name,
                               kd_entity *root);

/** Add a material to the store; its images are numbers in the store, KD_NONE for none. Returns its number. */
uint32_t kd_scene_add_material(kd_world *w, const kd_material_desc *desc);

/** Give every model's materials the values of its file again, which clips may have moved; images stay. */
void kd_scene_restore_materials(kd_world *w);

/** Get an image by its number in the store. Returns NULL when there is none of that number. */
const kd_image *kd_scene_image(const kd_scene_store *store, uint32_t number);

/** Give every mesh below `root` the material (kd_mesh_instance.material). */
void kd_scene_override_material(kd_world *w, kd_entity root, uint32_t material);

/** Play a clip of the instance by name (NULL or "": the first), blending from the one that runs over blend_s
 *  seconds. Errors KD_NOT_FOUND, the message lists the clips. */
kd_status kd_scene_play(kd_world *w, kd_entity root, const char *clip, bool loop, float speed, float blend_s);

/** Find a clip of the instance by name (NULL or "": the first): its number in kd_animation.clip, and its
 * length. Errors as kd_scene_play */
kd_status kd_scene_find_clip(kd_world *w, kd_entity root, const char *clip, uint32_t *number,
                             float *length_s);

/** Lay a clip over the instance's pose, fading in over blend_s.
 *  layer  1 … KD_ANIMATION_LAYERS; what it played before is replaced
 *  clip   NULL: fade out what it plays
 *  from   name of the node below which it moves the model; NULL: all of it
 *  Errors as kd_scene_play, OUT_OF_RANGE for a layer, NOT_FOUND for a node */
typedef struct kd_scene_layer {
    uint32_t layer;
    const char *clip, *from;
    bool loop;
    float speed, weight, blend_s;
} kd_scene_layer;
kd_status kd_scene_play_layer(kd_world *w, kd_entity root, const kd_scene_layer *play);

/** Copy an entity and what hangs below it, as last child of `parent` (KD_NO_ENTITY: as a root); instances
 * among it move and deform on their own. Errors as kd_instantiate, TOO_LARGE for more vertices than a draw
 * can name */
kd_status kd_scene_clone(kd_world *w, kd_entity prototype, kd_entity parent, kd_entity *out);

/** Register systems scene_upload, draw_list, draw_upload and camera. */
kd_status kd_scene_import(kd_schedule *s);

#endif
