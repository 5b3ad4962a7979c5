/* Render targets: framebuffer objects that keep what a clear must know about their attachments. */

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "runtime/gpu/internal.h"

static void attach(kd_gpu *gpu, GLuint framebuffer, GLenum point, const gpu_texture *texture,
                   const kd_gpu_target_desc *desc)
{
    if (texture->kind == KD_TEXTURE_2D || desc->layer == KD_ALL_LAYERS)
        gpu->gl.NamedFramebufferTexture(framebuffer, point, texture->gl, (GLint)desc->level);
    else
        gpu->gl.NamedFramebufferTextureLayer(framebuffer, point, texture->gl, (GLint)desc->level,
                                             (GLint)desc->layer);
}

static bool add_color(kd_gpu *gpu, gpu_target *target, const kd_gpu_target_desc *desc)
{
    GLenum buffers[KD_MAX_COLOR_TARGETS] = {GL_NONE};
    uint32_t i = 0;
    for (; i < KD_MAX_COLOR_TARGETS && desc->color[i].id; i++) {
        const gpu_texture *texture = gpu_get_texture(gpu, desc->color[i], "make_target");
        if (!texture)
            return false;
        attach(gpu, target->gl, GL_COLOR_ATTACHMENT0 + i, texture, desc);
        buffers[i] = GL_COLOR_ATTACHMENT0 + i;
        target->color_is_uint[i] = gpu_get_format(texture->format)->is_uint;
        target->width = gpu_level_size(texture->width, desc->level);
        target->height = gpu_level_size(texture->height, desc->level);
    }
    target->color_count = i;
    gpu->gl.NamedFramebufferDrawBuffers(target->gl, i ? (GLsizei)i : 1, buffers);
    gpu->gl.NamedFramebufferReadBuffer(target->gl, buffers[0]);
    return true;
}

static bool add_depth(kd_gpu *gpu, gpu_target *target, const kd_gpu_target_desc *desc)
{
    if (!desc->depth.id)
        return true;
    const gpu_texture *texture = gpu_get_texture(gpu, desc->depth, "make_target");
    if (!texture)
        return false;
    attach(gpu, target->gl, GL_DEPTH_ATTACHMENT, texture, desc);
    target->has_depth = true;
    target->width = gpu_level_size(texture->width, desc->level);
    target->height = gpu_level_size(texture->height, desc->level);
    return true;
}

/* A target without attachments only rasterizes: GL has to be told its size. */
static void set_size(kd_gpu *gpu, gpu_target *target, const kd_gpu_target_desc *desc)
{
    if (target->color_count || target->has_depth)
        return;
    target->width = desc->width;
    target->height = desc->height;
    gpu->gl.NamedFramebufferParameteri(target->gl, GL_FRAMEBUFFER_DEFAULT_WIDTH, (GLint)desc->width);
    gpu->gl.NamedFramebufferParameteri(target->gl, GL_FRAMEBUFFER_DEFAULT_HEIGHT, (GLint)desc->height);
}

kd_gpu_target kd_gpu_make_target(kd_gpu *gpu, const kd_gpu_target_desc *desc)
{
    assert(gpu && desc);
    gpu_target made = {0}, *target;
    gpu_copy_name(made.name, desc->name, "target");
    gpu->gl.CreateFramebuffers(1, &made.gl);
    bool good = add_color(gpu, &made, desc) && add_depth(gpu, &made, desc);
    if (good) {
        set_size(gpu, &made, desc);
        GLenum status = gpu->gl.CheckNamedFramebufferStatus(made.gl, GL_DRAW_FRAMEBUFFER);
        if (status != GL_FRAMEBUFFER_COMPLETE)
            gpu_fail(gpu, "target %s: the driver cannot draw to it (status 0x%x)", made.name, status);
        good = status == GL_FRAMEBUFFER_COMPLETE;
    }
    uint32_t id = good ? gpu_pool_add(&gpu->targets, (void **)&target) : 0;
    if (!id) {
        gpu->failed = true;
        gpu->gl.DeleteFramebuffers(1, &made.gl);
        return (kd_gpu_target){0};
    }
    *target = made;
    gpu_label(gpu, GL_FRAMEBUFFER, made.gl, made.name);
    return (kd_gpu_target){id};
}

void kd_gpu_destroy_target(kd_gpu *gpu, kd_gpu_target handle)
{
    gpu_target *target = handle.id ? gpu_get_target(gpu, handle, "destroy_target") : NULL;
    if (!target)
        return;
    gpu->raster_ready = false;
    gpu->gl.DeleteFramebuffers(1, &target->gl);
    gpu_pool_remove(&gpu->targets, handle.id);
}
