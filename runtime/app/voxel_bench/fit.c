#include "runtime/app/voxel_bench/fit.h"

static double mean_of(const double *values, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += values[i];
    return count ? sum / count : 0;
}

fit_line fit_points(const double *x, const double *y, uint32_t count)
{
    double mx = mean_of(x, count), my = mean_of(y, count), xx = 0, xy = 0, yy = 0;
    for (uint32_t i = 0; i < count; i++) {
        xx += (x[i] - mx) * (x[i] - mx);
        xy += (x[i] - mx) * (y[i] - my);
        yy += (y[i] - my) * (y[i] - my);
    }
    if (!(xx > 0))
        return (fit_line){0, my, 0};
    double slope = xy / xx;
    return (fit_line){slope, my - slope * mx, yy > 0 ? xy * xy / (xx * yy) : 1};
}
