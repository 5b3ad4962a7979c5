#ifndef KD_SYSTEMS_SCENE_INTERNAL_H
#define KD_SYSTEMS_SCENE_INTERNAL_H

/* What the files of systems/scene share: the store's private side and the draw list's working arrays. */

#include "components/mesh_instance.h"
#include "components/deform.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/core/box_tree.h"
#include "runtime/core/ranges.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/scene.h"

/* A box; empty when min.x > max.x. */
typedef struct scene_box {
    kd_vec3 min, max;
} scene_box;
#define SCENE_BOX_EMPTY ((scene_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}})
void scene_box_add(scene_box *box, kd_vec3 point);
void scene_box_join(scene_box *box, const scene_box *other);
/** Bound the box after an affine map given as three rows (x y z translation). */
scene_box scene_box_transform(const scene_box *box, const kd_vec4 rows[3]);
void scene_matrix_rows(const kd_mat4 *m, kd_vec4 rows[3]);

/* How far a primitive's vertices can go. Joint j moves only the vertices inside boxes[first_joint_box + j]; a
 * skinned vertex is a convex mean of its joints' images, so the union of the moved boxes holds it. Target t
 * adds at most its weight times boxes[first_morph_box + t], the box of its deltas. */
typedef struct scene_reach {
    uint32_t first_joint_box, joint_box_count;
    uint32_t first_morph_box, morph_box_count;
} scene_reach;

typedef struct scene_texture {
    uint32_t image;
    kd_wrap_mode wrap_s, wrap_t;
    bool srgb, nearest;
    kd_gpu_texture texture;
} scene_texture;

/* What one instance of a model holds in the store's lists besides deformed entries. */
typedef struct scene_instance {
    kd_range nodes, joints;
} scene_instance;

typedef struct scene_internal {
    uint32_t model_capacity, mesh_capacity, primitive_capacity, material_capacity, skin_capacity,
        clip_capacity;
    uint32_t deformed_capacity, deformed_primitive_capacity, joint_capacity, node_capacity;
    const kd_image **images; /* [image_count], numbered through the store */
    uint32_t image_count, image_capacity;
    scene_reach *reach; /* [primitive_count] */
    uint32_t reach_capacity;
    scene_box *boxes;
    uint32_t box_count, box_capacity;
    scene_texture *textures;
    uint32_t texture_count, texture_capacity;
    uint32_t uploaded_meshes, uploaded_materials, uploaded_deformed;
    uint32_t waiting_deformed; /* entries marked so */

    /* What instances hold, see give_back.c. The ends are the store's counts. */
    kd_ranges vertices, joints, nodes, deformed, deformed_primitives;
    scene_instance *instances;
    uint32_t instance_count, instance_capacity;
    kd_query *holders, *players; /* entities that refer to such parts */
    bool something_left;         /* one of them went since the last look */
    uint32_t trim_in;            /* frames until buffers are cut to what is in use; 0: no need */
    bool trim_now;
} scene_internal;

/** Get the store with its private side made. Returns NULL when memory is out. */
kd_scene_store *scene_store_get(kd_world *w);
/** Make room for `needed` items of `size` bytes; contents are kept. */
bool scene_reserve(void **items, uint32_t *capacity, uint64_t needed, size_t size);
#define SCENE_RESERVE(items, capacity, needed)                                                               \
    scene_reserve((void **)&(items), &(capacity), (needed), sizeof *(items))

/** Tell whether the primitive moves within its mesh when the instance has a skin (or not). */
static inline bool scene_primitive_deforms(const kd_store_primitive *p, bool with_skin)
{
    return p->first_morph_vertex != KD_NONE || (with_skin && p->first_skin_vertex != KD_NONE);
}

/** Count the vertices that an instance of the primitive takes when it deforms: its own and its cage's. */
static inline uint32_t scene_primitive_vertices(const kd_store_primitive *p)
{
    return p->vertex_count + p->cage_count;
}

/** Compute the boxes of `desc` into the store. `morph_count` is that of the store's mesh. */
kd_status scene_reach_add(scene_internal *in, const kd_primitive_desc *desc, uint32_t morph_count,
                          scene_reach *out);

/** Bound one primitive in world space. `rows`: palette of a skinned instance, or NULL; `weights` may be NULL.
 */
scene_box scene_primitive_bounds(const scene_internal *in, const kd_scene_store *store, uint32_t primitive,
                                 const kd_mat4 *world, const kd_vec4 (*rows)[3], uint32_t row_count,
                                 const kd_morph_weights *weights);

/* ---- packing: streams as shaders/shared/scene.h says ---- */
void scene_pack_geometry(const kd_primitive_desc *desc, uint32_t *words);
void scene_pack_attributes(const kd_primitive_desc *desc, uint32_t *words);
void scene_pack_skin(const kd_primitive_desc *desc, uint32_t *words);
/** Pack one morph target (zeros where the target has no deltas). */
void scene_pack_morph(const kd_primitive_desc *desc, uint32_t target, uint32_t *words);

/* ---- what instances hold and give back ---- */
/** Take `count` places of one of the store's lists, whose end is *end; room was reserved. */
uint32_t scene_take(kd_ranges *ranges, uint32_t *end, uint32_t count);
/** Give back what no entity refers to any more. */
void scene_give_back(kd_scene_store *store);
/** Watch for components that go. Errors NO_MEMORY */
kd_status scene_give_back_init(kd_world *w, scene_internal *in);
void scene_give_back_fini(kd_world *w, scene_internal *in);

/* ---- draw list ---- */
typedef struct scene_item {
    uint64_t order, entity_order; /* sorted by both */
    kd_entity entity;
    uint32_t primitive; /* store primitive */
    uint32_t part;      /* number within the mesh */
    const kd_mesh_instance *instance;
    const kd_mat4 *world;
    const kd_skin_instance *skin;    /* NULL when rigid */
    const kd_morph_weights *weights; /* NULL when not morphing */
    bool mirrored, deformed;
} scene_item;

/* What was last seen of an entity, by its index. */
typedef struct scene_shown {
    uint32_t generation;
    uint32_t first; /* its draws, chained through scene_draws.next; KD_NONE: none */
    bool moved;     /* its matrix has changed while it was drawn */
    bool skinned, morphing;
    kd_mesh_instance instance;
    kd_mat4 world;
} scene_shown;

/* Draws that go to the GPU together. */
#define SCENE_DIRTY_DRAWS 32

typedef struct scene_draws {
    kd_query *query;
    scene_item *items, *sorted;
    scene_item *current; /* one of both: by draw. Its pointers serve in the frame that set them alone */
    kd_draw *draws;
    kd_draw_batch *batches;
    struct kd_object *objects;
    kd_draw_indexed *args;
    uint32_t *next;  /* [draws] the next draw of the same entity, or KD_NONE */
    uint64_t *dirty; /* bits: SCENE_DIRTY_DRAWS draws each that the GPU has not as they are */
    uint32_t capacity, dirty_capacity, gpu_capacity;
    uint32_t *deforming, deforming_count; /* draws that may change without a row of theirs */
    scene_shown *shown;
    uint32_t shown_capacity;
    kd_box_tree tree;
    uint8_t *modes;
    uint32_t mode_count, mode_capacity;
    uint64_t version;            /* of the world when it was last looked at */
    uint32_t entities, revision; /* of the query and of the store then */
    uint32_t sent;               /* draws that went to the GPU last */
    uint32_t most;               /* draws that the GPU's buffers can hold; 0: not known */
    bool standing;               /* the list is whole */
    bool waiting;                /* something is not on the GPU yet */
    bool changed;                /* differs from what the GPU has */
    bool out_of_memory, said_most;
} scene_draws;
/** Get the draw list with its private side made. Returns NULL when memory is out. */
scene_draws *scene_draws_get(kd_draw_list *list);

/* What the list is made with. */
typedef struct scene_collector {
    scene_draws *draws;
    const kd_world *world;
    const kd_scene_store *store;
    const kd_joint_palette *palette;
    uint32_t count;
} scene_collector;

/* Rows of the list's query, and one of them as the common part of its items. */
typedef struct scene_rows {
    const kd_entity *entities;
    const kd_mesh_instance *instances;
    const kd_world_transform *worlds;
    const kd_skin_instance *skins;   /* or NULL */
    const kd_morph_weights *weights; /* or NULL */
} scene_rows;
bool scene_rows_next(kd_iter *it, scene_rows *rows);
scene_item scene_row(const scene_rows *rows, uint32_t i);

uint32_t scene_item_material(const kd_scene_store *store, const scene_item *item);
/** Set what follows from the rest: mirrored, and the place in the order. */
void scene_item_finish(const scene_collector *c, scene_item *item);
/** Write one draw, its object and its box. Room was reserved. */
void scene_emit_draw(const scene_collector *c, const scene_item *item, uint32_t number);
void scene_mark_dirty(scene_draws *d, uint32_t number);
/** Keep in mind what an entity is now. Returns false when memory is out. */
bool scene_show(scene_draws *d, const scene_item *entity);
/** Bring the list up to date in place. Returns false when it has to be made anew. */
bool scene_follow(const scene_collector *c);

/* ---- systems ---- */
kd_status scene_register_upload(kd_schedule *s);
kd_status scene_register_draw_list(kd_schedule *s);
kd_status scene_register_draw_upload(kd_schedule *s);
kd_status scene_register_camera(kd_schedule *s);

/** Give an instance vertices of its own where its mesh changes shape. Room was reserved.
 *  Returns its entry in kd_scene_store.deformed plus one */
uint32_t scene_add_deformed(kd_scene_store *s, uint32_t mesh, bool with_skin);
/** The next entity of the subtree in depth-first order; KD_NO_ENTITY at the end. No recursion: depth is the
 * file's choice. */
kd_entity scene_next_below(const kd_world *w, kd_entity root, kd_entity e);

#endif
