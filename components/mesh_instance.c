#include "components/mesh_instance.h"

KD_COMPONENT_DEFINE(kd_mesh_instance, "mesh_instance",
                    KD_FIELD(kd_mesh_instance, mesh, KD_U32, NULL, "mesh of the scene store"),
                    KD_FIELD(kd_mesh_instance, hidden, KD_BOOL, NULL,
                             "not drawn, casts no shadow, has no voxels"),
                    KD_FIELD(kd_mesh_instance, no_shadow, KD_BOOL, NULL, "casts no shadow"),
                    KD_FIELD(kd_mesh_instance, no_voxels, KD_BOOL, NULL, "does not enter the voxel scene"),
                    KD_FIELD(kd_mesh_instance, material, KD_U32, NULL,
                             "material of all its primitives plus one; 0: their own"),
                    KD_FIELD(kd_mesh_instance, deformed, KD_U32, NULL,
                             "deformed entry of the scene store plus one; 0: rigid"));

KD_COMPONENT_DEFINE(kd_skin_instance, "skin_instance",
                    KD_FIELD(kd_skin_instance, skin, KD_U32, NULL, "skin of the scene store"),
                    KD_FIELD(kd_skin_instance, first_joint, KD_U32, NULL,
                             "entry of the first joint in the store's joint entities"),
                    KD_FIELD(kd_skin_instance, first_matrix, KD_U32, NULL,
                             "first matrix in this frame's joint palette"));

KD_COMPONENT_DEFINE(kd_morph_weights, "morph_weights",
                    KD_FIELD_RANGE(kd_morph_weights, count, KD_U32, NULL, 0, KD_MAX_MORPH_TARGETS,
                                   "targets of the mesh"),
                    KD_FIELD_ARRAY(kd_morph_weights, weights, KD_F32, KD_MAX_MORPH_TARGETS, NULL,
                                   "weight of each target"));
