#ifndef KD_SYSTEMS_CONE_TRACE_CONES_H
#define KD_SYSTEMS_CONE_TRACE_CONES_H

#include "runtime/core/math.h"

/** Make a set of diffuse cones round +Z: one on the axis and the others in a ring (count 3 and 4: the ring
 * alone), placed so that they cover the hemisphere. w is the share of the cosine-weighted hemisphere that a
 * cone stands for; shares add up to 1. Shapes  out: count entries, 3 … 16 Returns the angle between two cones
 * of the largest ring */
float cones_make(kd_vec4 *out, unsigned count);

#endif
