#ifndef KD_SYSTEMS_HIERARCHY_HIERARCHY_H
#define KD_SYSTEMS_HIERARCHY_HIERARCHY_H

#include "runtime/ecs/system.h"

kd_status kd_hierarchy_import(kd_schedule *s);

#endif
