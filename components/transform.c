#include "components/transform.h"

static const kd_transform transform_default = KD_TRANSFORM_IDENTITY;
KD_COMPONENT_DEFINE_DEFAULT(kd_transform, "transform", &transform_default,
                            KD_FIELD(kd_transform, position, KD_VEC3, "m",
                                     "translation relative to the parent"),
                            KD_FIELD(kd_transform, rotation, KD_QUAT, NULL,
                                     "rotation relative to the parent, unit quaternion x y z w"),
                            KD_FIELD(kd_transform, scale, KD_VEC3, NULL,
                                     "scale along the local axes; a negative one mirrors"));

static const kd_local_matrix local_matrix_default = {{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}};
KD_COMPONENT_DEFINE_DEFAULT(kd_local_matrix, "local_matrix", &local_matrix_default,
                            KD_FIELD(kd_local_matrix, matrix, KD_MAT4, NULL,
                                     "pose relative to the parent, column-major; replaces transform"));

static const kd_world_transform world_transform_default = {
    {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}};
KD_COMPONENT_DEFINE_DEFAULT(kd_world_transform, "world_transform", &world_transform_default,
                            KD_FIELD(kd_world_transform, matrix, KD_MAT4, NULL,
                                     "model to world, column-major; written by the hierarchy system"));
