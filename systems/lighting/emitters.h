#ifndef KD_SYSTEMS_LIGHTING_EMITTERS_H
#define KD_SYSTEMS_LIGHTING_EMITTERS_H

#include "runtime/ecs/system.h"

kd_status emitters_import(kd_schedule *s);

#endif
