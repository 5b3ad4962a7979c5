#ifndef KD_COMPONENTS_FRAME_H
#define KD_COMPONENTS_FRAME_H

#include <stdbool.h>

#include "runtime/core/settings.h"
#include "runtime/ecs/system.h"

typedef enum kd_gi_technique { KD_GI_CONES, KD_GI_NONE } kd_gi_technique;
typedef enum kd_view_mode {
    KD_VIEW_FINAL,
    KD_VIEW_DIRECT,
    KD_VIEW_INDIRECT,
    KD_VIEW_AO,
    KD_VIEW_SPECULAR,
    KD_VIEW_ALBEDO,
    KD_VIEW_NORMAL,
    KD_VIEW_DEPTH,
    KD_VIEW_LIGHT,
    KD_VIEW_CACHES, /* from here on drawn by systems/debug_view */
    KD_VIEW_PAGES,
    KD_VIEW_OCTREE,
    KD_VIEW_LOOKUP,
    KD_VIEW_COST,
    KD_VIEW_MODE_COUNT
} kd_view_mode;

/* Singleton: what all systems of a frame know. Written between frames by the application. */
typedef struct kd_frame {
    uint64_t index;         /* simulation step, from 0 */
    double time_s;          /* index / fps */
    float dt_s;             /* 1 / fps */
    uint32_t width, height; /* of the picture */
    uint32_t gi;            /* kd_gi_technique */
    uint32_t view;          /* kd_view_mode */
    kd_settings settings;
} kd_frame;
KD_COMPONENT_DECLARE(kd_frame);

/** Tell whether the view draws voxels or the tree, and none of the frame's picture. */
bool kd_frame_shows_voxels(const kd_frame *frame);
/** What a view of voxels shows of them: `view.channel`, AUTO replaced by what suits the view. */
kd_view_channel kd_frame_channel(const kd_frame *frame);

/** Tell whether this frame's technique gathers light from voxels, or its view shows them: run_if of the voxel
 * systems. */
bool kd_frame_needs_voxels(kd_system_context *context);

#endif
