#ifndef KD_SYSTEMS_SHADOW_INTERNAL_H
#define KD_SYSTEMS_SHADOW_INTERNAL_H

/* What the shadow systems share: lights (CPU) fills one shadow_state a frame, lights_upload and shadow (GPU)
 * draw it. Lives in kd_lighting.internal from the init of `lights` to its fini. */

#include "components/light.h"
#include "components/render_targets.h"
#include "components/scene_store.h"
#include "components/camera.h"
#include "components/frame.h"
#include "components/material.h"
#include "components/mesh_instance.h"
#include "components/transform.h"
#include "runtime/core/frustum.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

enum {
    SHADOW_MAX_DIRECTIONAL = 2, /* directional lights that cast shadows */
    SHADOW_DIRECTIONAL_MATRICES = KD_MAX_SHADOW_CASCADES * SHADOW_MAX_DIRECTIONAL,
    SHADOW_MAX_LAYERS = SHADOW_DIRECTIONAL_MATRICES + KD_MAX_SPOT_SHADOWS
};

/* Draws of one layer that share a program and its parameters: part of the argument array. */
typedef struct shadow_run {
    uint32_t material; /* KD_NONE: opaque, no material needed */
    uint32_t first, count;
} shadow_run;

typedef struct shadow_layer {
    kd_mat4 matrix; /* world to [0,1]^3 */
    bool directional;
    uint32_t layer; /* of its texture array */
    uint32_t first_run, run_count;
} shadow_layer;

/* An array that grows and is kept between frames. */
typedef struct shadow_array {
    void *items;
    size_t capacity_bytes;
} shadow_array;

typedef struct shadow_state {
    struct kd_lights_params lights;
    struct kd_view_params view;
    kd_query *query;
    shadow_layer layers[SHADOW_MAX_LAYERS];
    uint32_t layer_count, directional_layers, spot_layers;
    uint32_t directional_edge, spot_edge; /* pixels */
    shadow_array args;                    /* kd_draw_indexed[arg_count] of all layers, in order */
    shadow_array runs;                    /* shadow_run[run_count] */
    shadow_array casters;                 /* uint8_t[draw_count]: casts a shadow */
    uint32_t arg_count, run_count;
    bool warned_lights, warned_layers, warned_directional;

    kd_gpu_program opaque, masked[2]; /* masked: without and with a base colour map */
    kd_gpu_buffer args_buffer;
    kd_gpu_target directional_targets[SHADOW_DIRECTIONAL_MATRICES], spot_targets[KD_MAX_SPOT_SHADOWS];
    uint32_t made_directional_layers, made_directional_edge, made_spot_layers, made_spot_edge;
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

/** Distance from p to the farthest corner of the bounds. */
float shadow_farthest(const shadow_bounds *bounds, kd_vec3 p);

/** Fill args and runs of every layer with the draws whose bounds it touches. Errors NO_MEMORY */
kd_status shadow_cull(shadow_state *s, kd_world *w, const kd_draw_list *list, const kd_scene_store *store);

/** The CPU system. */
kd_status shadow_lights_init(kd_system_context *context);
void shadow_lights_fini(kd_system_context *context);
void shadow_lights_run(kd_system_context *context);

#endif
