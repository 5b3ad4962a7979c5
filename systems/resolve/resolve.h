#ifndef KD_SYSTEMS_RESOLVE_RESOLVE_H
#define KD_SYSTEMS_RESOLVE_RESOLVE_H

#include "runtime/ecs/system.h"

kd_status kd_resolve_import(kd_schedule *s);

#endif
