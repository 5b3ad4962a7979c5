#ifndef KD_SYSTEMS_SHADOW_SHADOW_H
#define KD_SYSTEMS_SHADOW_SHADOW_H

#include "runtime/ecs/system.h"

kd_status kd_shadow_import(kd_schedule *s);

#endif
