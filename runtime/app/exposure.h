#ifndef KD_APP_EXPOSURE_H
#define KD_APP_EXPOSURE_H

/* The world between two simulation steps, for motion blur. The simulation goes on in whole steps, so that
 * what happens in it does not depend on how it is filmed: what was noted of two steps is mixed, shown, and
 * put back. Poses (and with them animated nodes), lenses, lights and morph weights are. */

#include "runtime/ecs/world.h"

typedef struct app_exposure app_exposure;

/** Make it for a world whose components are registered. Errors NO_MEMORY with a message */
kd_status app_exposure_make(kd_world *w, app_exposure **out);
void app_exposure_destroy(app_exposure *x); /* NULL does nothing */

/** Note the world as it is after a simulation step: it becomes the later one of the two. Errors NO_MEMORY
 * with a message */
kd_status app_exposure_note(app_exposure *x);
/** Show the world at a share of the way from the earlier step to the later one; 1 puts everything back, to
 * the bit. Who was not there in the earlier one does not move. */
void app_exposure_show(app_exposure *x, float share);

#endif
