#ifndef KD_SYSTEMS_BOUNCE_SOURCES_H
#define KD_SYSTEMS_BOUNCE_SOURCES_H

/* What gives light, from frame to frame: lamps, things that glow, the sky. Light that bounces builds up over
 * frames, so it has to begin anew when a source comes, goes or jumps. */

#include "runtime/ecs/query.h"

typedef struct light_source {
    uint64_t key;      /* the same thing in every frame */
    float flux;        /* lm, roughly: for shares of the whole */
    float place_ws[3]; /* m; of what shines from far away, its direction times the finest cascade's width */
    bool fresh;        /* the frame before had nothing of this key */
} light_source;

typedef struct light_sources {
    kd_query *lights, *skies;
    light_source *now, *before; /* ascending by key */
    uint32_t now_count, now_capacity, before_count, before_capacity;
    bool compared; /* there was a frame before */
} light_sources;

kd_status light_sources_init(light_sources *sources, kd_world *world);
void light_sources_fini(light_sources *sources);

/** Look at the world. Returns whether light has jumped since the last call: sources with a fiftieth of all
 * light have come, gone, moved an eighth of the finest cascade's width or changed by half, or the whole has
 * changed by a fifth. The first call returns false. */
bool light_sources_jumped(light_sources *sources, kd_world *world);

#endif
