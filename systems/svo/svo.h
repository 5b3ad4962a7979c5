#ifndef KD_SYSTEMS_SVO_SVO_H
#define KD_SYSTEMS_SVO_SVO_H

#include "runtime/ecs/system.h"

/** Register systems svo_prepare, svo_build and svo_filter. */
kd_status kd_svo_import(kd_schedule *s);

#endif
