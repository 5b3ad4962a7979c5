#ifndef KD_ASSET_MODEL_BOUNDS_H
#define KD_ASSET_MODEL_BOUNDS_H

#include <stdbool.h>

#include "runtime/asset/model.h"
#include "runtime/core/arena.h"

/** Fill triangle_count and bounds in the rest pose, over all node instances. Exact for up to 32 million
 * vertices, boxes of boxes beyond. Returns false when a place is not finite or memory is out. */
bool model_measure(kd_model *model, kd_arena *scratch);

#endif
