#ifndef KD_SYSTEMS_DEBUG_VIEW_INTERNAL_H
#define KD_SYSTEMS_DEBUG_VIEW_INTERNAL_H

#include "components/frame.h"
#include "components/render_targets.h"
#include "components/svo.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/debug_view.h"

/** Parameters of a view of voxels or of the tree. */
struct kd_debug_view_params debug_view_params(const kd_frame *frame, const kd_svo *svo);

/** Bind picture and camera, and show nothing so far. */
void debug_view_begin(kd_system_context *context);
/** Dispatch one invocation a pixel. */
void debug_view_dispatch(kd_system_context *context, kd_gpu_program program);

/* tree_view.c, voxel_view.c, cost_view.c */
kd_status debug_view_add_voxels(kd_schedule *s);
kd_status debug_view_add_tree(kd_schedule *s);
kd_status debug_view_add_cost(kd_schedule *s);

#endif
