/* FLIP for radiance: the pictures are shown at a range of exposures, and the largest difference counts.
 * Source  Andersson et al. 2021, Visualizing Errors in Rendered High Dynamic Range Images */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/compare/internal.h"
#include "runtime/core/color.h"
#include "runtime/core/log.h"

/* The ACES curve (k0 x^2 + k1 x) / (k2 x^2 + k3 x + k4). Source  Narkowicz 2015, 0.6 worked in */
static const double k[5] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};

static float tone(float x)
{
    double v = (double)x < 1e6 ? (double)x : 1e6;
    return (float)fmin(v * (k[0] * v + k[1]) / (v * (k[2] * v + k[3]) + k[4]), 1);
}

/* Input that the curve takes to 0.85, where it begins to saturate. */
static double shoulder(void)
{
    const double t = 0.85, a = k[0] - t * k[2], b = k[1] - t * k[3], c = -t * k[4];
    return (-b + sqrt(b * b - 4 * a * c)) / (2 * a);
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

kd_status kd_flip_exposures_of(const float *reference, uint32_t width, uint32_t height,
                               kd_flip_exposures *out)
{
    size_t count = (size_t)width * height;
    float *y = malloc(count * sizeof *y);
    if (!y)
        return kd_fail(KD_NO_MEMORY, "compare: no memory for pictures of %ux%u; choose a smaller size", width,
                       height);
    for (size_t i = 0; i < count; i++)
        y[i] = kd_color_luminance((kd_vec3){reference[i * 3], reference[i * 3 + 1], reference[i * 3 + 2]});
    qsort(y, count, sizeof *y, by_value);
    double median =
        count % 2 ? (double)y[count / 2] : 0.5 * ((double)y[count / 2 - 1] + (double)y[count / 2]);
    double most = (double)y[count - 1];
    free(y);
    most = fmax(most, 1e-10); /* a black picture is looked at as it is */
    median = fmax(median, most * 1e-6);
    out->start_ev = (float)log2(shoulder() / most);
    out->stop_ev = (float)log2(shoulder() / median);
    double steps = ceil((double)out->stop_ev - (double)out->start_ev);
    out->count = steps > 2 ? (uint32_t)steps : 2;
    return KD_OK;
}

static void expose(const float *radiance, float *out, size_t count, float ev)
{
    float factor = exp2f(ev);
    for (size_t i = 0; i < count * 3; i++)
        out[i] = tone(fmaxf(radiance[i] * factor, 0));
}

kd_status kd_flip_hdr(const float *test, const float *reference, uint32_t width, uint32_t height, float ppd,
                      const kd_flip_exposures *e, float *map, double *mean)
{
    flip_planes p;
    if (!flip_planes_make(&p, width, height, ppd))
        return KD_NO_MEMORY;
    float *shown = malloc(p.count * 8 * sizeof *shown);
    if (!shown) {
        flip_planes_fini(&p);
        return kd_fail(KD_NO_MEMORY, "compare: no memory for pictures of %ux%u; choose a smaller size", width,
                       height);
    }
    float *second = shown + p.count * 3, *one = shown + p.count * 6, *most = map ? map : shown + p.count * 7;
    memset(most, 0, p.count * sizeof *most);
    for (uint32_t i = 0; i < e->count; i++) {
        float ev =
            e->start_ev + (e->stop_ev - e->start_ev) * (float)i / (float)(e->count > 1 ? e->count - 1 : 1);
        expose(test, shown, p.count, ev);
        expose(reference, second, p.count, ev);
        flip_linear(&p, shown, second, one);
        for (size_t n = 0; n < p.count; n++)
            most[n] = fmaxf(most[n], one[n]);
    }
    *mean = flip_mean(most, p.count);
    free(shown);
    flip_planes_fini(&p);
    return KD_OK;
}
