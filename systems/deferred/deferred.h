#ifndef KD_SYSTEMS_DEFERRED_DEFERRED_H
#define KD_SYSTEMS_DEFERRED_DEFERRED_H

#include "runtime/ecs/system.h"

kd_status kd_deferred_import(kd_schedule *s);

#endif
