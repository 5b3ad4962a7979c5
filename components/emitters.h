#ifndef KD_COMPONENTS_EMITTERS_H
#define KD_COMPONENTS_EMITTERS_H

#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* Singleton: what glows, as few lights. Made by system emitters; read by light_inject, bounce and gather. */
typedef struct kd_emitters {
    kd_gpu_buffer list; /* resource "emitters": kd_emitters_params, uniform block KD_BIND_EMITTERS */
    kd_gpu_buffer sums; /* by blocks, shaders/shared/emitters.h */
    bool some;          /* the list may hold some */
} kd_emitters;
KD_COMPONENT_DECLARE(kd_emitters);

/** Bind the list to KD_BIND_EMITTERS. Threading: GPU lane */
void kd_emitters_bind(kd_gpu *gpu, const kd_emitters *emitters);

#endif
