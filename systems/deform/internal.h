#ifndef KD_SYSTEMS_DEFORM_INTERNAL_H
#define KD_SYSTEMS_DEFORM_INTERNAL_H

#include "components/deform.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/deform.h"

/* A growing array of which the last uploaded state is kept, so that a frame in which nothing moves costs the
 * GPU nothing. */
typedef struct deform_array {
    void *items, *previous; /* this frame's and the last frame's */
    uint32_t count, previous_count;
    uint32_t capacity, previous_capacity;
    uint32_t item_bytes;
} deform_array;
/** Append `n` zeroed items. Returns NULL when memory is out. */
void *deform_array_add(deform_array *array, uint32_t n);
/** Begin a frame: the array becomes the previous one. */
void deform_array_turn(deform_array *array);
bool deform_array_changed(const deform_array *array);

/* The palette's private side. */
typedef struct deform_work {
    kd_query *skins, *instances;
    deform_array rows;           /* kd_vec4[3] */
    deform_array items;          /* struct kd_deform_item */
    deform_array groups;         /* uint32_t[2]: item, first vertex */
    deform_array weights;        /* uint32_t[2]: target, bits of the float */
    deform_array surfaces;       /* struct kd_subdivide_item */
    deform_array surface_groups; /* uint32_t[2]: item, first row */
    uint32_t *first_matrix;      /* by first joint, plus one: instances that share joints share matrices */
    uint32_t first_matrix_capacity;
    bool rows_changed, work_changed;

    kd_gpu_program program, subdivide;
    kd_gpu_buffer items_buffer, words_buffer, surfaces_buffer, surface_words;
    bool surfaces_due; /* the deform pass has posed cages in this frame */
} deform_work;

/** Get the palette with its private side made. Returns NULL when memory is out. */
deform_work *deform_work_get(kd_joint_palette *palette);

/** List the work of this frame: items, groups and weights of every visible deformed instance. */
bool deform_list_work(deform_work *work, const kd_scene_store *store);

kd_status deform_register_joint_palette(kd_schedule *s);
kd_status deform_register_deform(kd_schedule *s);
kd_status deform_register_subdivide(kd_schedule *s);

/** A stream buffer of at least `size` bytes; contents are not kept. */
void deform_ensure(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name);
/** Make room in a stream buffer for the arrays and write them one after the other. */
void deform_upload(kd_gpu *gpu, kd_gpu_buffer *buffer, const char *name, const deform_array *first,
                   const deform_array *second);

#endif
