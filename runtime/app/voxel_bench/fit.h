#ifndef KD_APP_VOXEL_BENCH_FIT_H
#define KD_APP_VOXEL_BENCH_FIT_H

#include <stdint.h>

/* A straight line through points by least squares. */
typedef struct fit_line {
    double slope, intercept;
    double r2; /* share of the variance that the line explains */
} fit_line;

/** Fit. Of fewer than two points, or points above each other, the line is level through their mean and r2 is
 * 0. */
fit_line fit_points(const double *x, const double *y, uint32_t count);

#endif
