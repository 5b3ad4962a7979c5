/* Raster passes and draws. One vertex array is set up anew whenever the geometry differs from the last one's.
 */

#include <assert.h>
#include <string.h>

#include "runtime/gpu/internal.h"

static void enable(kd_gpu *gpu, GLenum what, bool on)
{
    if (on)
        gpu->gl.Enable(what);
    else
        gpu->gl.Disable(what);
}

static void set_depth(kd_gpu *gpu, const kd_gpu_raster *raster)
{
    bool offset = raster->depth_bias_slope != 0 || raster->depth_bias_constant != 0;
    /* GL writes depth only while the test is on: a write without a test is a test that always passes. */
    enable(gpu, GL_DEPTH_TEST, raster->depth_test || raster->depth_write || raster->depth_equal);
    gpu->gl.DepthFunc(raster->depth_equal ? GL_EQUAL : raster->depth_test ? GL_LEQUAL : GL_ALWAYS);
    gpu->gl.DepthMask(raster->depth_write ? GL_TRUE : GL_FALSE);
    enable(gpu, GL_DEPTH_CLAMP, raster->depth_clamp);
    enable(gpu, GL_POLYGON_OFFSET_FILL, offset);
    if (offset)
        gpu->gl.PolygonOffset(raster->depth_bias_slope, raster->depth_bias_constant);
}

static void set_cull_and_blend(kd_gpu *gpu, const kd_gpu_raster *raster)
{
    enable(gpu, GL_CULL_FACE, raster->cull != KD_CULL_NONE);
    if (raster->cull != KD_CULL_NONE)
        gpu->gl.CullFace(raster->cull == KD_CULL_BACK ? GL_BACK : GL_FRONT);
    enable(gpu, GL_BLEND, raster->blend != KD_BLEND_NONE);
    if (raster->blend == KD_BLEND_ALPHA)
        gpu->gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    else if (raster->blend == KD_BLEND_ADD)
        gpu->gl.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
    else if (raster->blend == KD_BLEND_TINT) {
        gpu->gl.BlendFunci(0, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
        gpu->gl.BlendFunci(1, GL_ONE, GL_ONE_MINUS_SRC_COLOR);
    }
}

static void clear_color(kd_gpu *gpu, const gpu_target *target, const float color[4])
{
    const GLfloat values[4] = {color[0], color[1], color[2], color[3]};
    GLuint integers[4];
    for (int i = 0; i < 4; i++)
        integers[i] = color[i] > 0 ? (GLuint)color[i] : 0;
    if (!target)
        gpu->gl.ClearNamedFramebufferfv(0, GL_COLOR, 0, values);
    for (uint32_t i = 0; target && i < target->color_count; i++) {
        if (target->color_is_uint[i])
            gpu->gl.ClearNamedFramebufferuiv(target->gl, GL_COLOR, (GLint)i, integers);
        else
            gpu->gl.ClearNamedFramebufferfv(target->gl, GL_COLOR, (GLint)i, values);
    }
}

static void clear(kd_gpu *gpu, const gpu_target *target, const kd_gpu_raster *raster, GLsizei width,
                  GLsizei height)
{
    static const GLfloat far_plane = 1;
    bool depth = raster->clear_depth && (!target || target->has_depth);
    if (!raster->clear_color && !depth)
        return;
    gpu->gl.Enable(GL_SCISSOR_TEST);
    gpu->gl.Scissor((GLint)raster->x, (GLint)raster->y, width, height);
    if (raster->clear_color)
        clear_color(gpu, target, raster->color);
    if (depth) {
        gpu->gl.DepthMask(GL_TRUE);
        gpu->gl.ClearNamedFramebufferfv(target ? target->gl : 0, GL_DEPTH, 0, &far_plane);
    }
    gpu->gl.Disable(GL_SCISSOR_TEST);
}

void kd_gpu_begin_raster(kd_gpu *gpu, const kd_gpu_raster *raster)
{
    uint32_t width = raster->width, height = raster->height, full_width = 0, full_height = 0;
    gpu_target *target = NULL;
    gpu->raster_ready = false;
    if (!raster->target.id && gpu->context.api == KD_CONTEXT_GLFW)
        kd_gpu_window_size(gpu, &full_width, &full_height);
    else if ((target = gpu_get_target(gpu, raster->target, "begin_raster")) == NULL)
        return;
    width = width ? width : target ? target->width : full_width;
    height = height ? height : target ? target->height : full_height;
    gpu->gl.BindFramebuffer(GL_FRAMEBUFFER, target ? target->gl : 0);
    /* Windows are written as they are: whether theirs is an sRGB buffer is up to the system. */
    enable(gpu, GL_FRAMEBUFFER_SRGB, target != NULL);
    gpu->gl.Viewport((GLint)raster->x, (GLint)raster->y, (GLsizei)width, (GLsizei)height);
    clear(gpu, target, raster, (GLsizei)width, (GLsizei)height);
    set_depth(gpu, raster);
    set_cull_and_blend(gpu, raster);
    gpu->raster_ready = true;
}

/* ---- geometry ---- */

static const struct {
    GLint components;
    GLenum type;
    GLboolean normalized;
    GLsizei bytes;
} attribute_formats[] = {
    [KD_ATTR_F32X1] = {1, GL_FLOAT, GL_FALSE, 4},
    [KD_ATTR_F32X2] = {2, GL_FLOAT, GL_FALSE, 8},
    [KD_ATTR_F32X3] = {3, GL_FLOAT, GL_FALSE, 12},
    [KD_ATTR_F32X4] = {4, GL_FLOAT, GL_FALSE, 16},
    [KD_ATTR_U32X1] = {1, GL_UNSIGNED_INT, GL_FALSE, 4},
    [KD_ATTR_UNORM8X4] = {4, GL_UNSIGNED_BYTE, GL_TRUE, 4},
    [KD_ATTR_SNORM8X4] = {4, GL_BYTE, GL_TRUE, 4},
    [KD_ATTR_SNORM16X2] = {2, GL_SHORT, GL_TRUE, 4},
    [KD_ATTR_SNORM16X4] = {4, GL_SHORT, GL_TRUE, 8},
    [KD_ATTR_F16X2] = {2, GL_HALF_FLOAT, GL_FALSE, 4},
};

void gpu_bind_vao(kd_gpu *gpu, GLuint vao)
{
    if (gpu->bound_vao == vao)
        return;
    gpu->gl.BindVertexArray(vao);
    gpu->bound_vao = vao;
}

static bool set_attribute(kd_gpu *gpu, const kd_gpu_attribute *attribute, GLuint binding)
{
    const gl_table *gl = &gpu->gl;
    const gpu_buffer *buffer = gpu_get_buffer(gpu, attribute->buffer, "draw");
    GLsizei stride =
        attribute->stride ? (GLsizei)attribute->stride : attribute_formats[attribute->format].bytes;
    GLuint location = attribute->location;
    if (!buffer)
        return false;
    gl->VertexArrayVertexBuffer(gpu->vao, binding, buffer->gl, (GLintptr)attribute->offset, stride);
    gl->VertexArrayBindingDivisor(gpu->vao, binding, attribute->per_instance ? 1 : 0);
    gl->VertexArrayAttribBinding(gpu->vao, location, binding);
    if (attribute->format == KD_ATTR_U32X1)
        gl->VertexArrayAttribIFormat(gpu->vao, location, 1, GL_UNSIGNED_INT, 0);
    else
        gl->VertexArrayAttribFormat(gpu->vao, location, attribute_formats[attribute->format].components,
                                    attribute_formats[attribute->format].type,
                                    attribute_formats[attribute->format].normalized, 0);
    gl->EnableVertexArrayAttrib(gpu->vao, location);
    return true;
}

/* Set the vertex array up for a geometry, unless it is so already. */
static bool set_geometry(kd_gpu *gpu, const kd_gpu_geometry *geometry)
{
    /* Padding may differ between equal geometries: that costs a set-up, never a wrong draw. */
    if (gpu->geometry_known && memcmp(&gpu->geometry, geometry, sizeof *geometry) == 0)
        return true;
    uint32_t enabled = 0;
    gpu->geometry_known = false;
    for (GLuint i = 0; i < KD_MAX_ATTRIBUTES && geometry->attributes[i].buffer.id; i++) {
        assert(geometry->attributes[i].location < 16);
        if (!set_attribute(gpu, &geometry->attributes[i], i))
            return false;
        enabled |= 1u << geometry->attributes[i].location;
        gpu->enabled_attributes |= enabled;
    }
    for (GLuint location = 0; location < 16; location++)
        if (gpu->enabled_attributes & ~enabled & 1u << location)
            gpu->gl.DisableVertexArrayAttrib(gpu->vao, location);
    gpu->enabled_attributes = enabled;
    if (geometry->indices.id) {
        const gpu_buffer *indices = gpu_get_buffer(gpu, geometry->indices, "draw");
        if (!indices)
            return false;
        gpu->gl.VertexArrayElementBuffer(gpu->vao, indices->gl);
    }
    memcpy(&gpu->geometry, geometry, sizeof *geometry);
    gpu->geometry_known = true;
    return true;
}

/* ---- draws ---- */

static bool begin_draw(kd_gpu *gpu, kd_gpu_program program, const char *call)
{
    if (!gpu->raster_ready) {
        gpu_complain(gpu, "%s: no raster pass has begun", call);
        return false;
    }
    return gpu_use_program(gpu, program, false, call);
}

void kd_gpu_draw_indexed(kd_gpu *gpu, kd_gpu_program program, const kd_gpu_geometry *geometry,
                         const kd_draw_indexed *draw)
{
    if (!draw->index_count || !draw->instance_count || !begin_draw(gpu, program, "draw_indexed") ||
        !set_geometry(gpu, geometry))
        return;
    gpu_bind_vao(gpu, gpu->vao);
    if (geometry->indices.id)
        gpu->gl.DrawElementsInstancedBaseVertexBaseInstance(
            GL_TRIANGLES, (GLsizei)draw->index_count, GL_UNSIGNED_INT,
            (const void *)(uintptr_t)((size_t)draw->first_index * sizeof(uint32_t)),
            (GLsizei)draw->instance_count, draw->base_vertex, draw->base_instance);
    else
        gpu->gl.DrawArraysInstancedBaseInstance(GL_TRIANGLES, (GLint)draw->first_index + draw->base_vertex,
                                                (GLsizei)draw->index_count, (GLsizei)draw->instance_count,
                                                draw->base_instance);
}

void kd_gpu_draw_indirect(kd_gpu *gpu, kd_gpu_program program, const kd_gpu_geometry *geometry,
                          kd_gpu_buffer draws, size_t offset, uint32_t draw_count)
{
    const gpu_buffer *buffer = draw_count ? gpu_get_buffer(gpu, draws, "draw_indirect") : NULL;
    assert(offset % 4 == 0);
    if (!buffer ||
        !gpu_range_fits(gpu, buffer, offset, draw_count * sizeof(kd_draw_indexed), "draw_indirect") ||
        !begin_draw(gpu, program, "draw_indirect") || !set_geometry(gpu, geometry))
        return;
    if (!geometry->indices.id) {
        gpu_complain(gpu, "draw_indirect: the geometry has no indices");
        return;
    }
    gpu_bind_vao(gpu, gpu->vao);
    gpu->gl.BindBuffer(GL_DRAW_INDIRECT_BUFFER, buffer->gl);
    gpu->gl.MultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, (const void *)(uintptr_t)offset,
                                      (GLsizei)draw_count, sizeof(kd_draw_indexed));
}

void kd_gpu_draw_procedural(kd_gpu *gpu, kd_gpu_program program, uint32_t count, uint32_t instances)
{
    if (!count || !instances || !begin_draw(gpu, program, "draw_procedural"))
        return;
    gpu_bind_vao(gpu, gpu->empty_vao);
    gpu->gl.DrawArraysInstancedBaseInstance(GL_TRIANGLES, 0, (GLsizei)count, (GLsizei)instances, 0);
}

void kd_gpu_blit_to_window(kd_gpu *gpu, kd_gpu_texture handle, uint32_t width, uint32_t height)
{
    const gpu_texture *texture = gpu_get_texture(gpu, handle, "blit_to_window");
    if (!texture)
        return;
    if (gpu->context.api != KD_CONTEXT_GLFW) {
        gpu_complain(gpu, "blit_to_window: a %s context has no window", gpu->info.api);
        return;
    }
    gpu->gl.NamedFramebufferTexture(gpu->blit_framebuffer, GL_COLOR_ATTACHMENT0, texture->gl, 0);
    gpu->gl.BindFramebuffer(GL_FRAMEBUFFER,
                            0); /* Mesa learns of a window's new size only while it is bound */
    gpu->gl.Disable(GL_FRAMEBUFFER_SRGB);
    gpu->raster_ready = false;
    gpu->gl.BlitNamedFramebuffer(gpu->blit_framebuffer, 0, 0, 0, (GLint)texture->width,
                                 (GLint)texture->height, 0, (GLint)height, (GLint)width, 0,
                                 GL_COLOR_BUFFER_BIT, GL_LINEAR);
    gpu->gl.NamedFramebufferTexture(gpu->blit_framebuffer, GL_COLOR_ATTACHMENT0, 0, 0);
}
