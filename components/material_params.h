#ifndef KD_COMPONENTS_MATERIAL_PARAMS_H
#define KD_COMPONENTS_MATERIAL_PARAMS_H

#include "components/scene_store.h"
#include "shaders/shared/scene.h"

/** Fill the uniform block KD_BIND_MATERIAL for a material of the store. */
struct kd_material_params kd_material_params_of(const kd_store_material *material);

/** Bind a material's maps to units KD_UNIT_BASE_COLOR … and its block to KD_BIND_MATERIAL. Threading: GPU lane. */
void kd_material_bind(kd_gpu *gpu, const kd_store_material *material);

#endif
