#ifndef KD_ASSET_MODEL_BOUNDS_H
#define KD_ASSET_MODEL_BOUNDS_H

#include <stdbool.h>

#include "runtime/asset/model.h"
#include "runtime/core/arena.h"

/** Fill triangle_count and bounds in the rest pose, over all node instances. Static meshes count with the corners of their
 *  boxes, skinned ones with every vertex. Returns false when a place is not finite or memory is out. */
bool model_measure(kd_model *model, kd_arena *scratch);

#endif
