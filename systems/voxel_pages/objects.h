#ifndef KD_SYSTEMS_VOXEL_PAGES_OBJECTS_H
#define KD_SYSTEMS_VOXEL_PAGES_OBJECTS_H

#include "components/deform.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/voxel_scene.h"
#include "systems/voxel_pages/caches.h"
#include "systems/voxel_pages/fixed_settings.h"

/* The table of voxel objects, kept up with the draw list: which primitives of which entities are in the voxel
 * scene, in which layer, and through which caches. */
typedef struct voxel_objects {
    uint32_t *slots;     /* open addressing: object plus one, by entity and primitive */
    uint32_t slot_count; /* a power of two */
    uint32_t used;      /* slots taken, also by objects that have left: their slots keep probe chains whole */
    uint32_t capacity;  /* of kd_voxel_scene.objects */
    uint32_t free_head; /* free objects are chained through kd_voxel_object.primitive, plus one */
    uint32_t live;
    voxel_caches caches;
    fixed_settings settings;
    kd_vec3 focus, step; /* now, and from the frame before to now; see ahead.c */
    bool focused;        /* there was a frame before */
    uint32_t ahead_frames;
    uint32_t *near; /* [2 * near_capacity] draws; see voxel_objects.c */
    uint32_t near_capacity;
} voxel_objects;

/** What an object is this frame. */
typedef struct voxel_sight {
    kd_entity entity;
    uint32_t draw_primitive; /* with the entity the object's key */
    uint32_t primitive;      /* store primitive, rest pose */
    uint32_t deformed;       /* deformed primitive plus one, or 0 */
    uint32_t kind, material;
    const kd_primitive_desc *desc;
    kd_mat4 model_ws;
    uint32_t first_matrix;
    float scale; /* largest stretch from model space to the world */
    kd_voxel_tile tile;
    uint32_t cascades; /* bits of the cascades in which it may stand */
    bool dynamic;      /* known to have moved */
    kd_vec3 bounds_min_ws, bounds_max_ws;
} voxel_sight;

/** Enter what is seen this frame into the table; marks it seen. May move kd_voxel_scene.objects. Errors
 * KD_NO_MEMORY */
kd_status objects_see(voxel_objects *table, kd_voxel_scene *scene, const voxel_sight *sight);

/** Free the entry of an object that has left all pages. */
void objects_forget(voxel_objects *table, kd_voxel_scene *scene, uint32_t object);

void objects_fini(voxel_objects *table, kd_voxel_scene *scene);

#endif
