#ifndef KD_SYSTEMS_DEFERRED_DEFERRED_H
#define KD_SYSTEMS_DEFERRED_DEFERRED_H

#include "runtime/ecs/system.h"

/** Register system geometry. */
kd_status kd_deferred_import(kd_schedule *s);
/** Register system blend: surfaces that let through what is behind them, drawn by themselves. */
kd_status kd_blend_import(kd_schedule *s);

#endif
