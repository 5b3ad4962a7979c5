#ifndef KD_COMPONENTS_LIGHT_JUMP_H
#define KD_COMPONENTS_LIGHT_JUMP_H

#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* Singleton: whether light has changed much since the frame before. Written by system light_jump; read by
 * whoever keeps light from frame to frame. */
typedef struct kd_light_jump {
    kd_gpu_buffer state; /* resource "light.jump": shaders/shared/jump.h */
    bool measured;       /* in this frame */
} kd_light_jump;
KD_COMPONENT_DECLARE(kd_light_jump);

#endif
