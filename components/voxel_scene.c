#include "components/voxel_scene.h"

KD_COMPONENT_DEFINE(kd_voxel_scene, "voxel_scene",
                    KD_FIELD(kd_voxel_scene, cascade_count, KD_U32, NULL, "nested grids in force"),
                    KD_FIELD(kd_voxel_scene, resolution, KD_U32, "voxels", "cells along an edge of every grid"),
                    KD_FIELD(kd_voxel_scene, span_m, KD_F32, "m", "edge of the finest voxels"),
                    KD_FIELD(kd_voxel_scene, cached_voxels, KD_U32, "voxels", "cached, over all primitives and spans"));
