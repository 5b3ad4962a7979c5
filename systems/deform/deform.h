#ifndef KD_SYSTEMS_DEFORM_DEFORM_H
#define KD_SYSTEMS_DEFORM_DEFORM_H

#include "runtime/ecs/system.h"

kd_status kd_deform_import(kd_schedule *s);

#endif
