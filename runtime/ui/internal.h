#ifndef KD_UI_INTERNAL_H
#define KD_UI_INTERNAL_H

/* Between the shim over Dear ImGui and the drawing of what it lays out. */

#include "runtime/ui/ui.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ui_vertex {
    float x, y; /* pixels, (0, 0) at the upper left */
    float u, v;
    uint32_t color; /* sRGB and opacity, red in the lowest byte */
} ui_vertex;

typedef struct ui_batch {
    uint32_t first_index, index_count;
    float clip[4]; /* left, top, right, bottom [pixels] */
} ui_batch;

/* Everything that one frame draws. */
typedef struct ui_geometry {
    const ui_vertex *vertices;
    const uint32_t *indices;
    const ui_batch *batches;
    uint32_t vertex_count, index_count, batch_count;
    uint32_t width, height; /* of the window, pixels */
} ui_geometry;

typedef struct ui_draw {
    kd_gpu *gpu;
    kd_gpu_program program;
    kd_gpu_texture font;
    kd_gpu_buffer vertices, indices;
} ui_draw;

kd_status ui_draw_open(ui_draw *draw, kd_gpu *gpu);
/** Take the letters: one byte of opacity a texel. */
kd_status ui_draw_font(ui_draw *draw, const uint8_t *texels, uint32_t width, uint32_t height);
void ui_draw_all(ui_draw *draw, const ui_geometry *geometry);
void ui_draw_close(ui_draw *draw);

/** Edit three sRGB values 0 … 1. */
bool ui_edit_srgb(kd_ui *ui, const char *label, float srgb[3]);

#ifdef __cplusplus
}
#endif

#endif
