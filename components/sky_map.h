#ifndef KD_COMPONENTS_SKY_MAP_H
#define KD_COMPONENTS_SKY_MAP_H

/* A sky as a picture in equirectangular projection: the middle looks along -Z, +X lies to the right of it,
 * row 0 looks straight up. */

#include <stdint.h>

#include "runtime/core/math.h"

typedef struct kd_sky_map {
    uint32_t width, height;
    const float *rgb; /* radiance, height rows of width RGB texels */
} kd_sky_map;

enum { KD_SKY_GRADIENT_WIDTH = 8, KD_SKY_GRADIENT_HEIGHT = 256 };

/** Fill a map of KD_SKY_GRADIENT_WIDTH x KD_SKY_GRADIENT_HEIGHT: linear in the height over the horizon.
 *  Shapes  rgb: 3 floats a texel */
void kd_sky_gradient(kd_vec3 zenith, kd_vec3 horizon, kd_vec3 ground, float *rgb);

/** Where a unit direction falls: x right and y down, 0 … 1. */
kd_vec2 kd_sky_place(kd_vec3 direction);
/** The unit direction of a place. */
kd_vec3 kd_sky_direction(kd_vec2 place);
/** Read bilinearly; columns go on from right to left. */
kd_vec3 kd_sky_sample(const kd_sky_map *map, kd_vec3 direction);

#endif
