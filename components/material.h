#ifndef KD_COMPONENTS_MATERIAL_H
#define KD_COMPONENTS_MATERIAL_H

#include "components/scene_store.h"
#include "shaders/shared/scene.h"

/** Write a stored material as shaders read it (uniform block KD_BIND_MATERIAL). A map counts as present when
 * its texture is on the GPU. Where blended surfaces enter the tree they
 * are cut at an opacity of one half. */
struct kd_material_params kd_material_params_make(const kd_store_material *material);

/** Tell whether a material reflects or lets through light in other ways than metallic-roughness says. */
bool kd_material_has_lobes(const kd_material_desc *desc);

/** Bind a material's maps to KD_UNIT_BASE_COLOR … and its block to KD_BIND_MATERIAL. Threading: the GPU lane.
 */
void kd_material_bind(kd_gpu *gpu, const kd_store_material *material);

#endif
