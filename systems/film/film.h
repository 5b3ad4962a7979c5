#ifndef KD_SYSTEMS_FILM_FILM_H
#define KD_SYSTEMS_FILM_FILM_H

#include "runtime/ecs/system.h"

/** Register systems motion and motion_keep: where everything was a frame ago. Before the geometry. */
kd_status kd_motion_import(kd_schedule *s);
/** Register systems film and film_layers: frames that are means of what is rendered, and their layers. After
 * whatever draws into the picture, before the tone map. */
kd_status kd_film_import(kd_schedule *s);

#endif
