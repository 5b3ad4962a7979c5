#ifndef KD_SYSTEMS_LIGHTING_LIGHTING_H
#define KD_SYSTEMS_LIGHTING_LIGHTING_H

#include "runtime/ecs/system.h"

kd_status kd_lighting_import(kd_schedule *s);

#endif
