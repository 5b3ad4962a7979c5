#ifndef KD_SYSTEMS_DEBUG_VIEW_DEBUG_VIEW_H
#define KD_SYSTEMS_DEBUG_VIEW_DEBUG_VIEW_H

#include "runtime/ecs/system.h"

/** Register system octree_view: `--view octree`. Must be imported before resolve, whose tone map shows what
 * it draws. */
kd_status kd_debug_view_import(kd_schedule *s);

#endif
