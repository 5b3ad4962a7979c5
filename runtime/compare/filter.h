#ifndef KD_COMPARE_FILTER_H
#define KD_COMPARE_FILTER_H

#include <stddef.h>
#include <stdint.h>

enum { FILTER_MAX_RADIUS = 255 };

/* One row of a separable filter, 2 radius + 1 weights. */
typedef struct filter_kernel {
    int radius;
    float weights[2 * FILTER_MAX_RADIUS + 1];
} filter_kernel;

/** Filter a plane by `x` along rows and `y` along columns; borders repeat. `scratch` holds a plane; out may
 * be in. */
void filter_plane(const float *in, float *out, float *scratch, uint32_t width, uint32_t height,
                  const filter_kernel *x, const filter_kernel *y);

#endif
