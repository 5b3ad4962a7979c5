#ifndef KD_COMPONENTS_VOXEL_SCENE_H
#define KD_COMPONENTS_VOXEL_SCENE_H

/* Singleton by which the voxel systems meet: where the cascades stand, which voxels are cached, which objects
 * are in which layer, and the buffers that hold it all. Layouts of the buffers: shaders/shared/voxel.h.
 *
 * Two layers: objects that have not moved since they came are static, their cells are kept; where the
 * cascades move, or a member comes, goes or changes, that part goes stale and is built anew. All others are
 * dynamic and come anew every frame. An object that moves once is dynamic for good, so what a frame shows
 * depends on the scenario and the frame's number alone. */

#include <stdbool.h>

#include "runtime/core/math.h"
#include "runtime/core/ranges.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/voxel.h"

typedef enum kd_voxel_layer { KD_LAYER_STATIC, KD_LAYER_DYNAMIC, KD_LAYER_COUNT } kd_voxel_layer;

/* A part of a primitive's voxels at one span. */
typedef struct kd_voxel_chunk {
    kd_vec3 origin;         /* model space */
    float span;             /* model space, m */
    uint32_t size[3];       /* cells, at most 1024 each */
    uint32_t first, count;  /* voxels in the cache */
    uint32_t first_binding; /* KD_EMPTY when rigid */
} kd_voxel_chunk;

struct kd_primitive_desc;

/* Primitives too large to be cached whole at a cascade's span are cut into tiles of the model's space, and
 * only those near the cascade are voxelized. Tile (x, y, z) holds the cells whose low corners lie in its box.
 */
typedef struct kd_voxel_tile {
    bool tiled;      /* false: the whole primitive */
    int32_t x, y, z; /* in edges of `edge` from the model's origin */
    float edge;      /* model space */
} kd_voxel_tile;

/* Voxels of one store primitive in one material at one span: one or more chunks. Objects share it; when none
 * has wanted it for a while it is given back, and its number is used again. */
typedef struct kd_voxel_cache {
    bool alive;
    uint32_t primitive; /* store primitive (rest pose) */
    uint32_t material;  /* the entity's own, or the primitive's */
    const struct kd_primitive_desc *desc;
    uint32_t kind; /* KD_VOXEL_* */
    bool thin;     /* 6-separating; else all that the surface touches */
    bool made;     /* its chunks are in the cache */
    float span;    /* model space */
    kd_vec3 phase; /* a point of the voxel lattice, model space */
    kd_voxel_tile tile;
    uint32_t first_chunk, chunk_count;
    uint32_t voxel_count;
    uint32_t wanted_at; /* run of system voxel_objects in which an object last wanted it */
    uint32_t due;       /* frames until an object will need it, if the camera goes on as it does; 0: now */
    float work;         /* estimated, to make it; 0: not estimated yet */
    uint32_t next;      /* plus one: in its chain of the table of caches, or of free entries */
} kd_voxel_cache;

/* One primitive of one entity, or one tile of it. Its number is its index; numbers of departed objects are
 * used again. */
typedef struct kd_voxel_object {
    kd_entity entity;
    uint32_t draw_primitive; /* as the draw list counts it; with the entity the object's key */
    uint32_t primitive;      /* store primitive (rest pose) */
    const struct kd_primitive_desc *desc;
    uint32_t deformed; /* deformed primitive plus one; 0 rigid */
    uint32_t kind;     /* KD_VOXEL_* */
    uint32_t material;
    kd_voxel_tile tile;
    uint32_t cascades; /* bits of the cascades in which it may stand */
    bool alive, seen;
    bool dynamic;         /* deforms, or has moved: its voxels no longer follow the world's lattice */
    bool becomes_dynamic; /* moved for the first time: leaves the static layer this frame */
    bool recache;         /* its segments hold voxels of a cache that no longer fits */
    kd_mat4 model_ws;
    uint32_t first_matrix; /* skinned: in this frame's joint palette */
    kd_vec3 bounds_min_ws, bounds_max_ws;
    kd_vec3 placed_min_ws, placed_max_ws; /* bounds with which it last came into pages */
    uint32_t ahead;     /* bits of the cascades whose caches are asked for ahead in this frame */
    uint32_t repaged;   /* bits of the cascades whose segments went this frame to come in again elsewhere */
    float cached_scale; /* largest axis scale its caches were made for */
    uint32_t caches[KD_MAX_CASCADES]; /* kd_voxel_scene.caches plus one; 0: none yet */
    uint32_t voxels[KD_MAX_CASCADES];
    uint32_t first_segment[KD_MAX_CASCADES],
        segment_count[KD_MAX_CASCADES]; /* 0: not included in that cascade */
} kd_voxel_object;

/* A layer's pages: fixed segments of 1024 voxels, each owned by one object. */
typedef struct kd_voxel_pages {
    uint32_t page_count, segment_count; /* pages made, segments in use */
    uint64_t voxel_count;               /* in the segments in use */
    kd_gpu_buffer segments;             /* kd_voxel_segment [page_count * KD_PAGE_SEGMENTS] */
    kd_gpu_buffer stacks;               /* per page: top, then KD_PAGE_SEGMENTS free slots */
    kd_gpu_buffer voxels;               /* dynamic layer: 3 words a voxel: cell, fraction, normal */
    kd_gpu_buffer bounds;               /* static layer: boxes of the groups of voxels in every slot */
    bool changed;                       /* members changed this frame */
} kd_voxel_pages;

typedef struct kd_voxel_scene {
    uint32_t cascade_count, resolution, resolution_log2;
    float span_m;
    bool one_layer; /* svo.layers = one: everything goes through the dynamic layer */
    uint32_t build; /* KD_SVO_BUILD_* of runtime/core/settings.h; all but orderfree have one layer */
    float span[KD_MAX_CASCADES];
    kd_vec3 origin_ws[KD_MAX_CASCADES];         /* low corners */
    int32_t origin_cells[KD_MAX_CASCADES][3];   /* the same in cells from the world's origin */
    int32_t previous_cells[KD_MAX_CASCADES][3]; /* of the frame before */
    bool placed;                                /* there was a frame before */
    bool moved;                                 /* the cascades moved this frame */
    bool static_changed; /* parts of the static layer are stale: they are built anew this frame */

    kd_voxel_cache *caches;
    kd_voxel_chunk *chunks;
    kd_voxel_object *objects;
    uint32_t cache_count, chunk_count, object_count; /* ends of these lists; free entries lie between */
    uint32_t unmade;                                 /* caches that are wanted and not made yet */
    bool want_all;           /* caches of everything in every cascade, wherever it stands: to make files */
    uint32_t voxelize_flags; /* KD_VOXEL_LEVEL_* of runtime/asset/voxel_file.h: how caches are made */
    const struct kd_voxel_file *given; /* looked into before anything is voxelized, or NULL; the setter's */
    uint32_t given_used;               /* caches that came out of it */
    kd_ranges voxel_places, binding_places,
        chunk_places;         /* who holds what of the cache buffers and of chunks */
    uint32_t cached_voxels;   /* in living caches */
    float brightest_emission; /* radiance of KD_EMISSION_ONE */
    float stored_unit;        /* radiance that the tree stores as 1: keeps suns in lux within half floats */

    kd_gpu_buffer cache_shape, cache_color, cache_binding; /* "voxels.cache" */
    kd_gpu_buffer chunk_params, object_params;             /* "voxels.objects" */
    kd_voxel_pages pages[KD_LAYER_COUNT];                  /* "voxels.pages" */
    kd_gpu_buffer stale;                                   /* "voxels.stale": kd_stale_places */
    kd_gpu_buffer stale_boxes;                             /* kd_stale_box [stale_box_count] */
    struct kd_stale_places stale_places;
    uint32_t stale_patch_count;
    uint32_t stale_box_count;

    void *internal; /* of system voxel_pages */
} kd_voxel_scene;
KD_COMPONENT_DECLARE(kd_voxel_scene);

/** Give back the places of a cache's voxels and chunks; it then holds none. */
void kd_voxel_cache_drop(kd_voxel_scene *scene, kd_voxel_cache *cache);

#endif
