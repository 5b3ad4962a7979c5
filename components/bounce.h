#ifndef KD_COMPONENTS_BOUNCE_H
#define KD_COMPONENTS_BOUNCE_H

#include "runtime/core/math.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* Singleton: light that leaves send out again, shaders/shared/bounce.h. Made by system bounce_prepare, filled
 * by bounce, read by light_inject. */
typedef struct kd_bounce {
    kd_gpu_buffer entries; /* resource "bounce"; a single entry when nothing bounces twice */
    kd_gpu_texture view;   /* of the entries, KD_UNIT_BOUNCE */
    uint32_t frame;        /* number of this frame, from 1 */
    uint32_t period;       /* frames in which every cell has its turn */
    uint32_t settling;     /* frames until light has found its level after it began anew */
    bool feeds;            /* entries of the frames before are there to be sent out */
    bool again;            /* this frame injects a second time, with entries of its own */
    bool settled;          /* nothing would change: set by light_inject */
} kd_bounce;
KD_COMPONENT_DECLARE(kd_bounce);

/* Entries older than this many turns are dropped: the cell has been empty since. */
#define KD_BOUNCE_MAX_TURNS 2u

#endif
