#ifndef KD_SYSTEMS_SHADOW_INTERNAL_H
#define KD_SYSTEMS_SHADOW_INTERNAL_H

/* What the shadow systems share: lights (CPU) fills one shadow_state a frame, lights_upload and shadow (GPU)
 * draw it. Lives in kd_lighting.internal from the init of `lights` to its fini. */

#include "components/light.h"
#include "components/render_targets.h"
#include "components/scene_store.h"
#include "components/sky.h"
#include "components/camera.h"
#include "components/deform.h"
#include "components/frame.h"
#include "components/material.h"
#include "components/mesh_instance.h"
#include "components/transform.h"
#include "runtime/core/frustum.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

enum {
    SHADOW_MAX_DIRECTIONAL = KD_MAX_DIRECTIONAL_SHADOWS,
    SHADOW_DIRECTIONAL_MATRICES = KD_MAX_SHADOW_CASCADES * SHADOW_MAX_DIRECTIONAL,
    SHADOW_MAX_LAYERS = SHADOW_DIRECTIONAL_MATRICES + KD_MAX_SPOT_SHADOWS,
    SHADOW_MAX_TARGETS = KD_MAX_SPOT_SHADOWS /* of one array */
};

/* Draws of one layer that share a program and its parameters: part of the argument array. */
typedef struct shadow_run {
    uint32_t material; /* KD_NONE: opaque, no material needed */
    uint32_t first, count;
} shadow_run;

/* All that the depth of one draw depends on, but for its layer's matrix. No padding: casters are compared as
 * bytes. */
typedef struct shadow_caster {
    uint32_t first_index, index_count, base_vertex;
    uint32_t material; /* KD_NONE: opaque */
    uint64_t pose;     /* checksum of matrix, joints and morph weights */
    uint64_t mask;     /* checksum of what the alpha test reads; 0: opaque */
} shadow_caster;
_Static_assert(sizeof(shadow_caster) == 32, "shadow_caster has no padding");

/* Casters of a layer and their runs: those that have never moved first, then the moving ones. */
typedef struct shadow_layer {
    kd_mat4 matrix; /* world to [0,1]^3 */
    bool directional;
    uint32_t layer;                      /* of its texture array */
    uint32_t first_arg, resting, moving; /* casters: parts of args and casters */
    uint32_t first_run, resting_runs, moving_runs;
} shadow_layer;

/* An array that grows and is kept between frames. */
typedef struct shadow_array {
    void *items;
    size_t capacity_bytes;
} shadow_array;

/* What a layer's map holds since it was last drawn, so that an equal frame need not draw it. */
typedef struct shadow_kept {
    bool valid;
    bool resting_valid; /* the second map holds the depth of its resting casters alone */
    kd_mat4 matrix;
    uint32_t resting, moving;
    shadow_array casters; /* shadow_caster[resting + moving] */
} shadow_kept;

/* A depth array with one target a layer. */
typedef struct shadow_maps {
    kd_gpu_texture texture;
    kd_gpu_target targets[SHADOW_MAX_TARGETS];
    uint32_t layers, edge;
} shadow_maps;

/* Where an entity stood when last seen. */
typedef struct shadow_pose {
    uint64_t checksum;
    uint32_t generation; /* of the entity with this index; 0: none yet */
    uint32_t seen;       /* shadow_state.cull_count of the frame that wrote it */
    bool moving;         /* has moved since it came; for good */
} shadow_pose;

typedef struct shadow_state {
    struct kd_lights_params lights;
    struct kd_view_params view;
    struct kd_lights_params lights_before; /* of the frame before, and the view, without its number */
    struct kd_view_params view_before;
    kd_query *query, *skies;
    shadow_layer layers[SHADOW_MAX_LAYERS];
    uint32_t layer_count, directional_layers, spot_layers;
    uint32_t directional_edge, spot_edge; /* pixels */
    shadow_array args;                    /* kd_draw_indexed[arg_count] of all layers, in order */
    shadow_array casters;                 /* shadow_caster[arg_count], beside args */
    shadow_array runs;                    /* shadow_run[run_count] */
    shadow_array visible; /* uint32_t[2 * draw_count]: draws of the layer at hand, and scratch */
    shadow_array draws;   /* shadow_draw[draw_count] of the draw list; see cull.c */
    shadow_pose *poses;   /* [pose_capacity], by index of the entity */
    uint32_t pose_capacity, cull_count;
    uint32_t arg_count, run_count;
    bool warned_lights, warned_layers, warned_directional;

    kd_gpu_program opaque, masked[2]; /* masked: without and with a base colour map */
    kd_gpu_buffer args_buffer;
    shadow_maps maps[2];    /* spots, directional; what kd_lighting hands on */
    shadow_maps resting[2]; /* of resting casters alone, made when a layer first needs one */
    shadow_kept kept[SHADOW_MAX_LAYERS];
    uint32_t drawn_casters, drawn_layers, copied_layers; /* in this frame */
    uint64_t bytes_moved;
} shadow_state;

/* Everything that is drawn, as a box; empty when there is nothing to draw. */
typedef struct shadow_bounds {
    kd_vec3 low, high;
    bool empty;
} shadow_bounds;

/** Make the array hold `bytes`; its contents may be lost. Returns NULL when memory is out. */
void *shadow_reserve(shadow_array *array, size_t bytes);

/** Compute radii of the cascades and where they stand. `edge`: pixels of a map.
 *  Units  metres; texel_ws and half_depth as kd_lights_params.cascade_texel_ws */
typedef struct shadow_cascade {
    kd_mat4 matrix;
    float texel_ws, half_depth;
} shadow_cascade;
void shadow_cascades_make(shadow_cascade *out, uint32_t count, kd_vec3 direction, kd_vec3 eye,
                          const shadow_bounds *bounds, float distance, uint32_t edge);

/** Make the matrix of a spot at `position` along `forward` with the tangent of its half angle. */
kd_mat4 shadow_spot_matrix(kd_vec3 position, kd_vec3 forward, float tangent, float z_near, float z_far);

/** Axis of a cube face in GL's order: +X -X +Y -Y +Z -Z. */
kd_vec3 shadow_cube_axis(uint32_t face);

/** Distance from p to the farthest corner of the bounds, rounded up to a power of the square root of two. */
float shadow_farthest(const shadow_bounds *bounds, kd_vec3 p);

/** Fill args and runs of every layer with the draws whose bounds it touches. Errors NO_MEMORY */
kd_status shadow_cull(shadow_state *s, kd_world *w, const kd_draw_list *list, const kd_scene_store *store);

/** Note that a layer's map now holds what the layer asks for. */
void shadow_remember(shadow_state *s, const shadow_layer *layer);
/** Forget what the maps of one kind held. */
void shadow_forget(shadow_state *s, bool directional);
typedef enum shadow_work {
    SHADOW_KEEP,        /* the map holds what it should */
    SHADOW_DRAW_MOVING, /* it differs in casters that move */
    SHADOW_DRAW_ALL
} shadow_work;
/** Compare a layer with what its map holds. */
shadow_work shadow_compare(const shadow_state *s, const shadow_layer *layer);
shadow_kept *shadow_kept_of(shadow_state *s, const shadow_layer *layer);

/** Make maps of so many layers and so large, unless they are there. Returns true when what they held is lost.
 */
bool shadow_maps_ensure(kd_gpu *gpu, shadow_maps *maps, uint32_t layers, uint32_t edge, const char *name);
void shadow_maps_destroy(kd_gpu *gpu, shadow_maps *maps);

/** The CPU system. */
kd_status shadow_lights_init(kd_system_context *context);
void shadow_lights_fini(kd_system_context *context);
void shadow_lights_run(kd_system_context *context);

#endif
