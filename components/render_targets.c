#include "components/render_targets.h"

KD_COMPONENT_DEFINE_FLAGS(kd_gbuffer, "gbuffer", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_gbuffer, width, KD_U32, "pixels", "width of its textures"),
                          KD_FIELD(kd_gbuffer, height, KD_U32, "pixels", "height of its textures"));

KD_COMPONENT_DEFINE_FLAGS(kd_lighting, "lighting", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_lighting, light_count, KD_U32, NULL, "lights of this frame"));

KD_COMPONENT_DEFINE_FLAGS(kd_gi_targets, "gi_targets", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_gi_targets, width, KD_U32, "pixels", "width of its textures"),
                          KD_FIELD(kd_gi_targets, height, KD_U32, "pixels", "height of its textures"));

KD_COMPONENT_DEFINE_FLAGS(kd_picture, "picture", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_picture, width, KD_U32, "pixels", "width of its textures"),
                          KD_FIELD(kd_picture, height, KD_U32, "pixels", "height of its textures"));

KD_COMPONENT_DEFINE_FLAGS(kd_tree, "tree", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_tree, cascade_count, KD_U32, NULL, "nested cascades"),
                          KD_FIELD(kd_tree, resolution, KD_U32, "voxels",
                                   "voxels a cascade has along an axis"),
                          KD_FIELD(kd_tree, dense_resolution, KD_U32, "voxels",
                                   "voxels of the finest dense level along an axis"),
                          KD_FIELD_ARRAY(kd_tree, span_m, KD_F32, 4, "m", "voxel edge of each cascade"));
