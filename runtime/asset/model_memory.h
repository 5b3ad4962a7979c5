#ifndef KD_ASSET_MODEL_MEMORY_H
#define KD_ASSET_MODEL_MEMORY_H

/* What kd_model.internal points to: the arena that a model stands in, and how many hold it. */

#include <stdint.h>

#include "runtime/core/arena.h"

typedef struct model_memory {
    kd_arena arena;
    uint32_t holders;
} model_memory;

#endif
