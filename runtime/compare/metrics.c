/* Differences in plain numbers, and the colours that show them. */

#include <math.h>
#include <stdlib.h>

#include "runtime/compare/internal.h"
#include "runtime/core/log.h"

double kd_relative_mse(const float *test, const float *reference, uint32_t width, uint32_t height)
{
    size_t count = (size_t)width * height * 3;
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        double t = (double)test[i], r = (double)reference[i];
        sum += (t - r) * (t - r) / (r * r + 0.01);
    }
    return count ? sum / (double)count : 0;
}

/* ---- structural similarity ---- */

static void window(filter_kernel *out)
{
    float sum = 0;
    out->radius = 5;
    for (int i = -5; i <= 5; i++)
        sum += out->weights[i + 5] = expf(-(float)(i * i) / (2 * 1.5f * 1.5f));
    for (int i = 0; i < 11; i++)
        out->weights[i] /= sum;
}

static double similarity(double ma, double mb, double aa, double bb, double ab)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double va = fmax(aa - ma * ma, 0), vb = fmax(bb - mb * mb, 0), covariance = ab - ma * mb;
    return (2 * ma * mb + c1) * (2 * covariance + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

kd_status kd_ssim(const float *a, const float *b, uint32_t width, uint32_t height, double *mean)
{
    size_t count = (size_t)width * height;
    filter_kernel *k = malloc(sizeof *k);
    float *planes = malloc(count * 6 * sizeof *planes), *p[6];
    if (!planes || !k) {
        free(planes);
        free(k);
        return kd_fail(KD_NO_MEMORY, "compare: no memory for pictures of %ux%u; choose a smaller size", width,
                       height);
    }
    for (size_t i = 0; i < 6; i++)
        p[i] = planes + i * count;
    for (size_t i = 0; i < count; i++) {
        p[0][i] = 0.2126f * a[i * 3] + 0.7152f * a[i * 3 + 1] + 0.0722f * a[i * 3 + 2];
        p[1][i] = 0.2126f * b[i * 3] + 0.7152f * b[i * 3 + 1] + 0.0722f * b[i * 3 + 2];
        p[2][i] = p[0][i] * p[0][i];
        p[3][i] = p[1][i] * p[1][i];
        p[4][i] = p[0][i] * p[1][i];
    }
    window(k);
    for (int i = 0; i < 5; i++)
        filter_plane(p[i], p[i], p[5], width, height, k, k);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum +=
            similarity((double)p[0][i], (double)p[1][i], (double)p[2][i], (double)p[3][i], (double)p[4][i]);
    *mean = count ? sum / (double)count : 1;
    free(planes);
    free(k);
    return KD_OK;
}

/* ---- heat ---- */

void kd_heat_color(float value, float rgb[3])
{
    static const float stops[6][3] = {{0, 0, 0.02f},         {0.23f, 0.06f, 0.44f}, {0.55f, 0.16f, 0.51f},
                                      {0.87f, 0.29f, 0.41f}, {0.99f, 0.62f, 0.43f}, {0.99f, 0.99f, 0.75f}};
    float x = value > 0 ? (value < 1 ? value : 1) * 5 : 0;
    int i = x < 5 ? (int)x : 4;
    for (int c = 0; c < 3; c++)
        rgb[c] = stops[i][c] + (stops[i + 1][c] - stops[i][c]) * (x - (float)i);
}
