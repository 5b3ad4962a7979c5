#ifndef KD_COMPARE_COMPARE_H
#define KD_COMPARE_COMPARE_H

/* How different two pictures are, to an eye and in numbers. Pictures are height rows of width texels of 3
 * floats, row 0 on top; maps have one float a pixel. Every value must be finite. Threading: any. */

#include <stddef.h>
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

/* Beyond it there is no surface. Metres */
#define KD_NO_DEPTH 1e9f

/* What is known of the surfaces of a picture beside their light, one value a pixel each. */
typedef struct kd_surfaces {
    const float *depth;     /* metres along the view */
    const float *normal[3]; /* world space */
    const float
        *motion[2]; /* pixels from here to where the surface was a frame before, x to the right, y down */
} kd_surfaces;

/** Make of a picture the one a frame later, as far as its surfaces can still be seen there.
 *
 *  Shapes  before_rgb, now_rgb, out: width * height * 3; seen: width * height, 1 where out was found in
 *          before_rgb, 0 where the surface was hidden or outside then: there out is now_rgb
 *  Returns how many pixels are seen
 */
size_t kd_reproject(const kd_surfaces *before, const float *before_rgb, const kd_surfaces *now,
                    const float *now_rgb, uint32_t width, uint32_t height, float *out, uint8_t *seen);

/** Get the mean of a map over the pixels that are seen; 0 when none is. */
double kd_mean_seen(const float *map, const uint8_t *seen, size_t count);

/** Colour of a difference 0 … 1: black over violet and orange to pale yellow, sRGB codes. */
void kd_heat_color(float value, float rgb[3]);

#endif
