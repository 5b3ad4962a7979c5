#ifndef KD_APP_VOXEL_BENCH_RIG_H
#define KD_APP_VOXEL_BENCH_RIG_H

/* A scene that is run to be measured: the whole runtime at the size of a stamp, with the stages of the voxel
 * scene added up from the profile of its systems. */

#include "runtime/app/scene.h"
#include "runtime/app/timing.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/voxel.h"

/* The stages by which Yalciner 2016, tables 5.1 to 5.3, counts. */
typedef enum rig_stage {
    RIG_IO,        /* objects, caches, pages */
    RIG_TRANSFORM, /* voxels to the world */
    RIG_BUILD,     /* "reconstruct" */
    RIG_FILTER,    /* "average" */
    RIG_STAGE_COUNT
} rig_stage;
extern const char *const rig_stage_names[RIG_STAGE_COUNT];

typedef struct rig_time {
    double median_ms, min_ms, max_ms;
} rig_time;

/* What was measured over some frames; counts are those of the last one. */
typedef struct rig_figures {
    rig_time stages[RIG_STAGE_COUNT];
    rig_time frame;                                    /* whole frames */
    uint64_t voxels, dynamic_voxels, deforming_voxels; /* in pages */
    uint64_t cells;                                    /* occupied leaf cells */
    uint64_t nodes[4];                                 /* by level, from the dense one */
    uint64_t layer_bytes;                              /* one layer's mask of leaf cells */
    uint64_t gpu_bytes, tree_bytes, cache_bytes, page_bytes;
    uint32_t levels, warnings; /* warnings: that came while the rig ran */
} rig_figures;

typedef struct rig {
    kd_jobs *jobs;
    kd_world *world;
    kd_gpu *gpu;
    kd_schedule *schedule;
    app_scene scene;
    app_timing timing;
    app_options options; /* the command line's, with the rig's own settings behind */
    const char **sets;
    uint64_t frame;
    uint32_t warnings_before;
} rig;

/** Open a scene with settings on top of the command line's.
 *  scene  path of a scenario or model
 *  sets   "KEY=VALUE", ended by NULL; the command line's own --set come first
 *  Errors with one message; the rig is closed then */
kd_status rig_open(rig *r, const app_options *options, const char *scene, const char *const *sets);
void rig_close(rig *r);

/** Run frames without measuring. Errors with one message; INTERRUPTED */
kd_status rig_run(rig *r, uint32_t frames);

/** Called before each measured frame, to move something. */
typedef void rig_step(rig *r, void *user);

/** Run frames and measure them. `step` may be NULL. Errors as rig_run */
kd_status rig_measure(rig *r, uint32_t frames, rig_step *step, void *user, rig_figures *out);

/** Put a camera of the rig's own in the place of the scene's. */
kd_status rig_take_camera(rig *r, kd_vec3 eye, kd_vec3 target, kd_entity *camera);

/** Hide all meshes that are there. Errors NO_MEMORY */
kd_status rig_hide_all(rig *r);

/** Sum of transform, build and filter: what grows with voxels. */
double rig_tree_ms(const rig_figures *f);
/** Sum of all four stages. */
double rig_total_ms(const rig_figures *f);

#endif
