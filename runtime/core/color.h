#ifndef KD_CORE_COLOR_H
#define KD_CORE_COLOR_H

/* From linear light to the screen and back: shaders/include/color.glsl in C. Primaries are those of sRGB. */

#include <stdint.h>

#include "runtime/core/math.h"
#include "runtime/core/settings.h"

/* Linear value of each 8 bit sRGB code. Source  IEC 61966-2-1 */
extern const float kd_color_from_srgb8[256];

/** Rec. 709 */
float kd_color_luminance(kd_vec3 c);
/** One channel, clamped to 0 … 1. Source  IEC 61966-2-1 */
float kd_color_srgb_encode(float linear);
float kd_color_srgb_decode(float encoded);

/** Radiance to sRGB codes 0 … 1: exposure (a factor), tone curve, encoding. */
kd_vec3 kd_color_screen(kd_vec3 radiance, float exposure, kd_tonemap curve);

/** Round an encoded channel 0 … 1 to eight bits. */
uint8_t kd_color_byte(float encoded);

#endif
