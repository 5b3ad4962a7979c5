#ifndef KD_COMPONENTS_SCENE_STORE_H
#define KD_COMPONENTS_SCENE_STORE_H

/* Singleton: what entities refer to by number. The CPU side is filled by kd_scene_instantiate
 * (systems/scene); the GPU side follows in the next frame's phase animate (system scene_upload). Models and
 * what they bring stay while the world lives; what an instance has of its own (deformed entries with their
 * vertices, joint and node entities) is given back once no entity refers to it, and its numbers are used
 * again. Nothing is ever moved. */

#include <stdbool.h>

#include "runtime/asset/model.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

typedef struct kd_store_primitive {
    uint32_t first_index, index_count;  /* in the index buffer; values count from base_vertex */
    uint32_t base_vertex, vertex_count; /* in the geometry and attribute streams */
    uint32_t material;                  /* kd_scene_store.materials */
    uint32_t first_skin_vertex;         /* in the skin stream, or KD_NONE */
    uint32_t first_morph_vertex; /* in the morph stream (targets of vertex_count entries each), or KD_NONE */
    kd_vec3 bounds_min, bounds_max; /* model space, rest pose */
    uint32_t cage_count; /* vertices of its subdivision cage, which follow its own in the geometry, skin and
                            morph streams; 0: no cage */
    uint32_t first_row, first_stencil; /* of the cage's stencils, one row a vertex */
} kd_store_primitive;

typedef struct kd_store_mesh {
    const char *name;
    uint32_t first_primitive, primitive_count;
    uint32_t morph_count;
    bool skinned;
    kd_vec3 bounds_min, bounds_max;
    const kd_mesh_desc *desc; /* lives as long as the store */
} kd_store_mesh;

/* Vertices of one deformed instance: a copy of its mesh's streams that the deform system rewrites every
 * frame. */
typedef struct kd_store_deformed {
    kd_entity entity;
    uint32_t mesh;
    uint32_t first_primitive; /* deformed_primitives: one per primitive of the mesh */
    bool waiting;             /* a number used again, whose vertices are not on the GPU yet */
} kd_store_deformed;

typedef struct kd_store_material {
    kd_material_desc desc;  /* its images are numbers in the store */
    kd_gpu_texture maps[5]; /* in order of KD_MAP_*; id 0: none */
} kd_store_material;

typedef struct kd_store_skin {
    uint32_t joint_count;
    const kd_mat4 *inverse_bind;
} kd_store_skin;

typedef struct kd_store_clip {
    const kd_clip_desc *desc;
    uint32_t model;
} kd_store_clip;

typedef struct kd_store_model {
    const kd_model *model;
    uint32_t first_mesh, first_material, first_skin, first_clip, first_image;
} kd_store_model;

typedef struct kd_scene_store {
    /* growing arrays, count and items; see systems/scene */
    uint32_t model_count, mesh_count, primitive_count, material_count, skin_count, clip_count;
    uint32_t deformed_count, deformed_primitive_count, joint_entity_count, node_entity_count;
    kd_store_model *models;
    kd_store_mesh *meshes;
    kd_store_primitive *primitives;
    kd_store_material *materials; /* 0: what primitives without one get */
    kd_store_skin *skins;
    kd_store_clip *clips;
    kd_store_deformed *deformed;
    kd_store_primitive *deformed_primitives; /* base_vertex points at the instance's own vertices */
    kd_entity *joint_entities;
    kd_entity *node_entities;
    uint64_t triangle_count; /* of all meshes, once each */

    /* GPU side: resources "scene.vertices" (geometry and attribute streams), "scene.indices", "scene.static"
     * (skin, morph) */
    kd_gpu_buffer geometry, attributes, indices, skins_buffer, morphs;
    kd_gpu_buffer stencil_rows, stencils; /* of cages, "scene.static" too: see shaders/shared/deform.h */
    uint32_t vertex_count, index_count, skin_vertex_count, morph_vertex_count; /* reserved so far */
    uint32_t stencil_row_count, stencil_count;
    uint32_t uploaded_primitives; /* primitives below this number are on the GPU */
    uint32_t revision;            /* raised whenever meshes or materials were added */
    void *internal;
    void (*release)(
        struct kd_scene_store *store); /* frees the CPU side with the world; set by systems/scene */
} kd_scene_store;
KD_COMPONENT_DECLARE(kd_scene_store);

/* Singleton: what is drawn this frame; written by system draw_list (phase cull). Resource "scene.objects". */
typedef struct kd_draw_batch {
    uint32_t material;
    uint32_t first_draw, draw_count;
    bool mirrored; /* front faces turn over */
    bool voxels;   /* some of them enter the voxel scene */
} kd_draw_batch;
typedef struct kd_draw {
    kd_draw_indexed args; /* base_instance is the object's index */
    kd_entity entity;
    uint32_t primitive; /* store primitive, or deformed primitive when deformed */
    bool deformed;
    bool moved;                           /* the entity's matrix has changed since it was first drawn */
    kd_vec3 bounds_min_ws, bounds_max_ws; /* conservative; of deformed objects from their joints */
} kd_draw;
typedef struct kd_draw_list {
    uint32_t draw_count, batch_count, object_count;
    const kd_draw *draws;         /* sorted by batch */
    const kd_draw_batch *batches; /* opaque first, then mask, then blend */
    kd_gpu_buffer objects;        /* kd_object[object_count] */
    kd_gpu_buffer object_ids;     /* 0, 1, 2 …: per-instance attribute KD_LOC_OBJECT */
    kd_gpu_buffer args;           /* kd_draw_indexed[draw_count] in the order of draws */
    const uint32_t *deforming;    /* [deforming_count] numbers of the draws that deform */
    uint32_t deforming_count;
    const struct kd_box_tree *tree; /* of the draws by number; still: rigid, with voxels, never moved. NULL:
                                       none yet */
    kd_vec3 bounds_min_ws, bounds_max_ws; /* of everything drawn */
    void *internal;
    void (*release)(
        struct kd_draw_list *list); /* frees the CPU side with the world; set by system draw_list */
} kd_draw_list;
KD_COMPONENT_DECLARE(kd_draw_list);

#endif
