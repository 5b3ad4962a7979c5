#ifndef KD_SYSTEMS_BOUNCE_BOUNCE_H
#define KD_SYSTEMS_BOUNCE_BOUNCE_H

#include "runtime/ecs/system.h"

/** Register systems bounce_prepare and bounce: light that arrives at dense cells of the octree, for leaves to
 * send out again (`light.bounces` 2 or inf). */
kd_status kd_bounce_import(kd_schedule *s);

#endif
