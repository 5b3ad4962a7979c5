#ifndef KD_COMPARE_COMPARE_H
#define KD_COMPARE_COMPARE_H

/* How different two pictures are, to an eye and in numbers. Pictures are height rows of width texels of 3
 * floats, row 0 on top; maps have one float a pixel. Every value must be finite. Threading: any. */

#include <stdint.h>

#include "runtime/core/status.h"

/* A screen 0.7 m wide with 3840 pixels, 0.7 m away. Source  Andersson et al. 2020, section 6 */
#define KD_FLIP_PIXELS_PER_DEGREE 67.0206f

/** Compute the difference seen when two pictures are flipped on a screen.
 *
 *  Shapes  a, b: width * height * 3, sRGB codes 0 … 1; map: width * height or NULL
 *  Units   pixels_per_degree: of the viewer's field; 0: KD_FLIP_PIXELS_PER_DEGREE
 *  Returns the mean over all pixels in *mean, 0 (equal) … 1
 *  Errors  KD_NO_MEMORY with a message
 *  Source  Andersson et al. 2020, FLIP: A Difference Evaluator for Alternating Images
 */
kd_status kd_flip_ldr(const float *a, const float *b, uint32_t width, uint32_t height,
                      float pixels_per_degree, float *map, double *mean);

/* Exposures at which radiance is looked at. */
typedef struct kd_flip_exposures {
    float start_ev, stop_ev;
    uint32_t count;
} kd_flip_exposures;

/** Choose them by the reference: from its brightest pixel near white to its median near white.
 *  Source  Andersson et al. 2021, Visualizing Errors in Rendered High Dynamic Range Images, section 3 */
kd_status kd_flip_exposures_of(const float *reference, uint32_t width, uint32_t height,
                               kd_flip_exposures *out);

/** The same for linear radiance: the largest difference at any of the exposures, pixel by pixel.
 *  Shapes  as kd_flip_ldr, linear, not negative
 *  Source  Andersson et al. 2021, equation 5, with the ACES curve
 */
kd_status kd_flip_hdr(const float *test, const float *reference, uint32_t width, uint32_t height,
                      float pixels_per_degree, const kd_flip_exposures *exposures, float *map, double *mean);

/** Mean squared error relative to the reference: mean of (t - r)^2 / (r^2 + 0.01) over all channels. 0.01
 * keeps black finite. */
double kd_relative_mse(const float *test, const float *reference, uint32_t width, uint32_t height);

/** Structural similarity of the luma of two pictures of sRGB codes; 1: equal. Errors  KD_NO_MEMORY with a
 * message Source  Wang et al. 2004, Image Quality Assessment: Gaussian window of 11x11, deviation 1.5; K1
 * 0.01, K2 0.03 */
kd_status kd_ssim(const float *a, const float *b, uint32_t width, uint32_t height, double *mean);

/** Colour of a difference 0 … 1: black over violet and orange to pale yellow, sRGB codes. */
void kd_heat_color(float value, float rgb[3]);

#endif
