#ifndef KD_SYSTEMS_SKY_SKY_H
#define KD_SYSTEMS_SKY_SKY_H

#include "runtime/ecs/system.h"

/** Register system sky. */
kd_status kd_sky_import(kd_schedule *s);

#endif
