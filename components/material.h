#ifndef KD_COMPONENTS_MATERIAL_H
#define KD_COMPONENTS_MATERIAL_H

#include "components/scene_store.h"
#include "shaders/shared/scene.h"

/** Write a stored material as shaders read it (uniform block KD_BIND_MATERIAL). A map counts as present when
 * its texture is on the GPU. Blended materials are cut at an opacity of one half, since nothing is sorted. */
struct kd_material_params kd_material_params_make(const kd_store_material *material);

#endif
