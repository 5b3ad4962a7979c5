#ifndef KD_SYSTEMS_CONE_TRACE_CONE_TRACE_H
#define KD_SYSTEMS_CONE_TRACE_CONE_TRACE_H

#include "runtime/ecs/system.h"

kd_status kd_cone_trace_import(kd_schedule *s);

#endif
