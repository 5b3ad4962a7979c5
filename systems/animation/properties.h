#ifndef KD_SYSTEMS_ANIMATION_PROPERTIES_H
#define KD_SYSTEMS_ANIMATION_PROPERTIES_H

/* What clips move besides nodes: materials, lights and cameras. */

#include "components/scene_store.h"

typedef struct animation_moment {
    const kd_clip_desc *clip, *previous; /* the latter is blended out, or NULL */
    float time_s, previous_time_s, previous_weight;
} animation_moment;

/** Write what the clips say at a moment, on its way from what the clip before said, or from rest.
 *
 *  model     of the store; its materials are moved there, for all of its instances
 *  entities  of its nodes; their lights and cameras are moved
 */
void animation_write_properties(kd_world *w, kd_scene_store *store, const kd_store_model *model,
                                const kd_entity *entities, const animation_moment *moment);

#endif
