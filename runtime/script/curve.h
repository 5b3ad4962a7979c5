#ifndef KD_SCRIPT_CURVE_H
#define KD_SCRIPT_CURVE_H

/* A smooth path through points, walked at constant speed: what cameras and trains run on. */

#include <stdbool.h>
#include <stdint.h>

#include "runtime/core/math.h"

#define SCRIPT_CURVE_STEPS 32 /* pieces by which the length of a segment is measured */

typedef struct script_curve {
    uint64_t order;       /* of a scenario's object; see internal.h */
    uint32_t point_count; /* 2 at least */
    bool closed;
    float length_m;
    kd_vec3 *points;  /* [point_count] */
    float *lengths_m; /* [segments * SCRIPT_CURVE_STEPS + 1]: from the start to each piece */
} script_curve;

uint32_t script_curve_segments(const script_curve *curve);
/** Measure the lengths; points, count and closed are set. */
void script_curve_measure(script_curve *curve);
/** Get the point at a share of the length and the unit direction there (NULL: not wanted).
 *
 *  Units   share: 0 … 1; a closed path goes round, an open one is held at its ends
 *  Source  Yuksel, Schaefer, Keyser: "Parameterization and applications of Catmull-Rom curves", 2011
 *          (centripetal: no loops and cusps within a segment)
 */
kd_vec3 script_curve_at(const script_curve *curve, double share, kd_vec3 *direction);

#endif
