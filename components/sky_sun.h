#ifndef KD_COMPONENTS_SKY_SUN_H
#define KD_COMPONENTS_SKY_SUN_H

/* The sun in a picture of a sky: one small place that is far brighter than what is round it. Taken as a
 * directional light it has shadows, which means over cones have not. */

#include <stdbool.h>

#include "components/sky_map.h"

typedef struct kd_sky_sun {
    kd_vec3 direction;  /* of the map, to the middle of its light; unit */
    kd_vec3 irradiance; /* on what faces it, of all that is brighter than round it */
    kd_vec3 round;      /* mean radiance round it */
} kd_sky_sun;

/** Find it. A map of fewer rows than KD_SKY_SUN_ROWS has texels that are too large for one.
 *
 *  Units    those of the map
 *  Returns  false when nothing is bright and small enough, or memory is out; `out` is then all zero
 *  Threading  any; depends on the map alone
 */
bool kd_sky_sun_find(const kd_sky_map *map, kd_sky_sun *out);

/** Write the map without its sun: near to it nothing is brighter than what is round it.
 *  Shapes  rgb: 3 floats a texel */
void kd_sky_sun_remove(const kd_sky_map *map, const kd_sky_sun *sun, float *rgb);

enum { KD_SKY_SUN_ROWS = 64 };

#endif
