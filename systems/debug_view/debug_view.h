#ifndef KD_SYSTEMS_DEBUG_VIEW_DEBUG_VIEW_H
#define KD_SYSTEMS_DEBUG_VIEW_DEBUG_VIEW_H

#include "runtime/ecs/system.h"

/** Register the systems of the views that are drawn in place of the picture: view_voxels
 * (caches, pages), view_tree (octree, lookup) and view_cost. Must
 * be imported before resolve, whose tone map shows what they draw. */
kd_status kd_debug_view_import(kd_schedule *s);

#endif
