#ifndef KD_COMPARE_INTERNAL_H
#define KD_COMPARE_INTERNAL_H

/* What both forms of FLIP share. */

#include <stdbool.h>
#include <stddef.h>

#include "runtime/compare/compare.h"
#include "runtime/compare/filter.h"

#define FLIP_PI 3.14159265358979f

enum { FLIP_PLANES = 14 };

/* One float a pixel each. */
typedef struct flip_planes {
    uint32_t width, height;
    size_t count;
    float ppd;
    float *color[2][3];
    float *lightness[2], *length[2], *feature, *spare[3];
    filter_kernel *kernels; /* three */
    float *memory;
} flip_planes;

/** Errors with a message; returns false then. */
bool flip_planes_make(flip_planes *p, uint32_t width, uint32_t height, float ppd);
void flip_planes_fini(flip_planes *p);

/** Compare two pictures of linear values 0 … 1. */
void flip_linear(flip_planes *p, const float *a, const float *b, float *map);

double flip_mean(const float *map, size_t count);

#endif
