#ifndef KD_SYSTEMS_CONE_TRACE_GRID_H
#define KD_SYSTEMS_CONE_TRACE_GRID_H

/* Textures of the cone tracer, in the picture's size and smaller. */

#include "runtime/gpu/gpu.h"

/* Light of every n-th pixel of both axes: as traced, smoothed, and as traced in the frame before. */
typedef struct gather_grid {
    kd_gpu_texture diffuse[3], specular[3];
    uint32_t width, height;
} gather_grid;
enum { GRID_TRACED, GRID_SMOOTH, GRID_BEFORE };

/** Make a texture of a size in place of another. */
void grid_remake(kd_gpu *gpu, kd_gpu_texture *texture, kd_texture_format format, uint32_t width,
                 uint32_t height, const char *name);
/** Give a grid a size. Returns true when it had another. */
bool grid_fit(kd_gpu *gpu, gather_grid *grid, uint32_t width, uint32_t height);
/** What was traced becomes what was traced in the frame before. */
void grid_begin_frame(gather_grid *grid);
void grid_destroy(kd_gpu *gpu, gather_grid *grid);

#endif
