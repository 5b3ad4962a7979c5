#ifndef KD_CORE_HALF_H
#define KD_CORE_HALF_H

/* IEEE 754 half floats, as pictures and textures keep them. */

#include <stdint.h>

/** Round to the nearest half, ties to even; what is larger than 65504 becomes 65504, NaN 0. */
uint16_t kd_half_from_float(float f);
float kd_half_to_float(uint16_t half);

#endif
