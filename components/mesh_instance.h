#ifndef KD_COMPONENTS_MESH_INSTANCE_H
#define KD_COMPONENTS_MESH_INSTANCE_H

#include <stdbool.h>

#include "runtime/core/math.h"
#include "runtime/ecs/world.h"

/* A mesh of the scene store, drawn and voxelized at the entity's world transform (at its joints, when
 * skinned). */
typedef struct kd_mesh_instance {
    uint32_t mesh;     /* kd_scene_store.meshes */
    bool hidden;       /* not drawn, no shadow, no voxels */
    bool no_shadow;    /* casts no shadow */
    bool no_voxels;    /* does not enter the voxel scene */
    uint32_t material; /* of every primitive instead of its own, plus one; 0: none */
    uint32_t deformed; /* kd_scene_store.deformed entry plus one; 0: rigid. Set by the scene system */
} kd_mesh_instance;
KD_COMPONENT_DECLARE(kd_mesh_instance);

/* The joints of a skinned mesh: a skin of the scene store and where its joint entities start in the store's
 * list. */
typedef struct kd_skin_instance {
    uint32_t skin;         /* kd_scene_store.skins */
    uint32_t first_joint;  /* kd_scene_store.joint_entities, one entry a joint */
    uint32_t first_matrix; /* in this frame's joint palette; written by the deform system */
} kd_skin_instance;
KD_COMPONENT_DECLARE(kd_skin_instance);

#define KD_MAX_MORPH_TARGETS 64
/* Weights of a morphing mesh. */
typedef struct kd_morph_weights {
    uint32_t count;
    float weights[KD_MAX_MORPH_TARGETS];
} kd_morph_weights;
KD_COMPONENT_DECLARE(kd_morph_weights);

#endif
