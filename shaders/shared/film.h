#ifndef KD_SHADERS_FILM_H
#define KD_SHADERS_FILM_H

#include "shaders/shared/layout.h"

/* Slices of the layers. Light is linear radiance, and
 * final = direct + indirect + emission + blended. */
#define KD_LAYER_FINAL 0u
#define KD_LAYER_DIRECT 1u   /* straight from lamps */
#define KD_LAYER_INDIRECT 2u /* all that was gathered */
#define KD_LAYER_SPECULAR 3u /* the glossy part of it */
#define KD_LAYER_EMISSION 4u /* what glows, and the background */
#define KD_LAYER_BLENDED 5u  /* rgb: light of blended surfaces in front, a: share that they hide */
#define KD_LAYER_ALBEDO 6u
#define KD_LAYER_NORMAL 7u   /* world space */
#define KD_LAYER_MOTION 8u   /* xy: pixels to where it was a frame ago, y downwards; z + w: depth [m], less than 0: nothing */
#define KD_LAYER_COUNT 9

/* The mean of pixels and of sub-frames. */
struct kd_film_params {
    uvec4 mode;  /* x: rendered pixels along an axis, y: 1 in the first sub-frame, z: 1 in the last, w: 1 when
                    the GI targets hold light */
    /* ---- 16 */
    vec4 weight; /* x: of one rendered pixel, y: unit of the light in the GI targets; zw 0 */
    /* ---- 32 */
    mat4 previous_view_projection;
    /* ---- 96 */
};
KD_LAYOUT_CHECK(kd_film_params, 96)

/* What drawing with motion knows of the frame before. */
struct kd_motion_params {
    mat4 view_projection;
    /* ---- 64 */
    vec4 size; /* xy: pixels; zw 0 */
    /* ---- 80 */
};
KD_LAYOUT_CHECK(kd_motion_params, 80)

#include "shaders/shared/layout_end.h"

#endif
