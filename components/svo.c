#include "components/svo.h"

KD_COMPONENT_DEFINE_FLAGS(
    kd_svo, "svo", KD_COMPONENT_TRANSIENT, KD_FIELD(kd_svo, cascades, KD_U32, NULL, "nested grids"),
    KD_FIELD(kd_svo, leaf_level, KD_U32, NULL, "level of the leaves: 2^level cells along an edge"),
    KD_FIELD(kd_svo, node_capacity, KD_U32, "nodes", "room for nodes above the leaves"));
