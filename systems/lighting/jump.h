#ifndef KD_SYSTEMS_LIGHTING_JUMP_H
#define KD_SYSTEMS_LIGHTING_JUMP_H

#include "runtime/ecs/system.h"

kd_status jump_import(kd_schedule *s);

#endif
