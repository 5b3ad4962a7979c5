#ifndef KD_SYSTEMS_ANIMATION_ANIMATION_H
#define KD_SYSTEMS_ANIMATION_ANIMATION_H

#include "runtime/ecs/system.h"

kd_status kd_animation_import(kd_schedule *s);

#endif
