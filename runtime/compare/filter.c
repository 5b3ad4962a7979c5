#include "runtime/compare/filter.h"

static uint32_t clamped(int64_t i, uint32_t size)
{
    return (uint32_t)(i < 0 ? 0 : i >= (int64_t)size ? (int64_t)size - 1 : i);
}

static void filter_row(const float *in, float *out, uint32_t width, const filter_kernel *k)
{
    for (uint32_t x = 0; x < width; x++) {
        float sum = 0;
        if (x >= (uint32_t)k->radius && x + (uint32_t)k->radius < width) {
            const float *from = in + x - k->radius;
            for (int i = 0; i <= 2 * k->radius; i++)
                sum += from[i] * k->weights[i];
        } else {
            for (int i = -k->radius; i <= k->radius; i++)
                sum += in[clamped((int64_t)x + i, width)] * k->weights[i + k->radius];
        }
        out[x] = sum;
    }
}

void filter_plane(const float *in, float *out, float *scratch, uint32_t width, uint32_t height,
                  const filter_kernel *kx, const filter_kernel *ky)
{
    for (uint32_t y = 0; y < height; y++)
        filter_row(in + (size_t)y * width, scratch + (size_t)y * width, width, kx);
    for (uint32_t y = 0; y < height; y++) {
        float *row = out + (size_t)y * width;
        for (uint32_t x = 0; x < width; x++)
            row[x] = 0;
        for (int i = -ky->radius; i <= ky->radius; i++) {
            const float *from = scratch + (size_t)clamped((int64_t)y + i, height) * width;
            float weight = ky->weights[i + ky->radius];
            for (uint32_t x = 0; x < width; x++)
                row[x] += from[x] * weight;
        }
    }
}
