/* Draws panels: one program, one texture of letters, a batch for each rectangle that cuts what lies in it. */
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/ui/internal.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/ui.h"

kd_status ui_draw_open(ui_draw *draw, kd_gpu *gpu)
{
    *draw = (ui_draw){.gpu = gpu};
    draw->program = kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.vertex = "shaders/ui/ui.vert", .fragment = "shaders/ui/ui.frag"});
    return draw->program.id ? KD_OK : KD_GPU;
}

kd_status ui_draw_font(ui_draw *draw, const uint8_t *texels, uint32_t width, uint32_t height)
{
    kd_gpu_destroy_texture(draw->gpu, draw->font);
    draw->font = kd_gpu_make_texture(
        draw->gpu, &(kd_gpu_texture_desc){
                       .format = KD_R8, .width = width, .height = height, .data = texels, .name = "ui font"});
    return draw->font.id ? KD_OK : KD_GPU;
}

/* Grow by doubling: what is shown changes from frame to frame. */
static bool ensure(ui_draw *draw, kd_gpu_buffer *buffer, size_t bytes, const char *name)
{
    size_t size = (size_t)64 << 10;
    while (size < bytes)
        size *= 2;
    if (!buffer->id)
        *buffer = kd_gpu_make_buffer(
            draw->gpu, &(kd_gpu_buffer_desc){.size = size, .usage = KD_BUFFER_STREAM, .name = name});
    return buffer->id && kd_gpu_ensure_buffer(draw->gpu, buffer, size, 0, name) == KD_OK;
}

static bool upload(ui_draw *draw, const ui_geometry *g)
{
    size_t vertex_bytes = g->vertex_count * sizeof *g->vertices;
    size_t index_bytes = g->index_count * sizeof *g->indices;
    if (!ensure(draw, &draw->vertices, vertex_bytes, "ui vertices") ||
        !ensure(draw, &draw->indices, index_bytes, "ui indices"))
        return false;
    kd_gpu_write_buffer(draw->gpu, draw->vertices, 0, g->vertices, vertex_bytes);
    kd_gpu_write_buffer(draw->gpu, draw->indices, 0, g->indices, index_bytes);
    return true;
}

void ui_draw_all(ui_draw *draw, const ui_geometry *g)
{
    if (!g->batch_count || !g->width || !g->height || !upload(draw, g))
        return;
    const kd_gpu_geometry geometry = {
        .attributes = {{draw->vertices, 0, KD_ATTR_F32X2, offsetof(ui_vertex, x), sizeof(ui_vertex), false},
                       {draw->vertices, 1, KD_ATTR_F32X2, offsetof(ui_vertex, u), sizeof(ui_vertex), false},
                       {draw->vertices, 2, KD_ATTR_UNORM8X4, offsetof(ui_vertex, color), sizeof(ui_vertex),
                        false}},
        .indices = draw->indices};
    kd_gpu_begin_raster(draw->gpu, &(kd_gpu_raster){.cull = KD_CULL_NONE, .blend = KD_BLEND_ALPHA});
    kd_gpu_bind_texture(draw->gpu, KD_UNIT_UI_FONT, draw->font);
    for (uint32_t i = 0; i < g->batch_count; i++) {
        const ui_batch *b = &g->batches[i];
        struct kd_ui_params params = {
            .clip = {b->clip[0], b->clip[1], b->clip[2], b->clip[3]},
            .to_ndc = {2 / (float)g->width, -2 / (float)g->height, (float)g->height, 0}};
        kd_gpu_bind_uniform(draw->gpu, KD_BIND_PASS, &params, sizeof params);
        kd_gpu_draw_indexed(draw->gpu, draw->program, &geometry,
                            &(kd_draw_indexed){.index_count = b->index_count,
                                               .instance_count = 1,
                                               .first_index = b->first_index});
    }
}

void ui_draw_close(ui_draw *draw)
{
    if (!draw->gpu)
        return;
    kd_gpu_destroy_program(draw->gpu, draw->program);
    kd_gpu_destroy_texture(draw->gpu, draw->font);
    kd_gpu_destroy_buffer(draw->gpu, draw->vertices);
    kd_gpu_destroy_buffer(draw->gpu, draw->indices);
    *draw = (ui_draw){0};
}
