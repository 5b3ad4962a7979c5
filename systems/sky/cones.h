#ifndef KD_SYSTEMS_SKY_CONES_H
#define KD_SYSTEMS_SKY_CONES_H

#include <stdbool.h>

#include "components/sky_map.h"

/** Compute means over discs as shaders/shared/sky.h lays them out. Returns false when memory is out.
 *  Shapes  out: KD_SKY_LAYERS * KD_SKY_EDGE * KD_SKY_EDGE texels of 4 half floats
 *  Cost    some 30 ms */
bool sky_cones_make(const kd_sky_map *map, uint16_t *out);

#endif
