/* What all kinds of objects share: failures, names, and the way from a handle to the object behind it. */

#include <stdio.h>
#include <string.h>

#include "runtime/gpu/internal.h"

void gpu_fail(kd_gpu *gpu, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    gpu->failed = true;
    kd_log(KD_LOG_ERROR, "%s", text);
}

void gpu_complain(kd_gpu *gpu, const char *format, ...)
{
    char text[512];
    gpu->failed = true;
    if (gpu->complaints++ >= GPU_MAX_COMPLAINTS)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    kd_log(KD_LOG_ERROR, "%s%s", text,
           gpu->complaints == GPU_MAX_COMPLAINTS ? " (further GPU errors are not shown)" : "");
}

void gpu_drain_errors(kd_gpu *gpu)
{
    /* A lost context may report errors for ever. */
    for (int i = 0; i < 16; i++) {
        GLenum error = gpu->gl.GetError();
        if (error == GL_NO_ERROR)
            return;
        if (!gpu->debug)
            gpu_complain(gpu, "OpenGL reported %s", gl_error_name(error));
    }
}

void gpu_copy_name(char out[GPU_MAX_NAME], const char *name, const char *fallback)
{
    snprintf(out, GPU_MAX_NAME, "%s", name ? name : fallback);
}

void gpu_label(kd_gpu *gpu, GLenum kind, GLuint object, const char *name)
{
    if (gpu->debug)
        gpu->gl.ObjectLabel(kind, object, -1, name);
}

static void *get(kd_gpu *gpu, const gpu_pool *pool, uint32_t id, const char *kind, const char *call)
{
    void *item = gpu_pool_find(pool, id);
    if (!item && id)
        gpu_complain(gpu, "%s: the %s was destroyed before; keep it alive while it is used", call, kind);
    else if (!item)
        gpu_complain(gpu, "%s: there is no such %s, its making failed; nothing was done", call, kind);
    return item;
}

gpu_buffer *gpu_get_buffer(kd_gpu *gpu, kd_gpu_buffer buffer, const char *call)
{
    return get(gpu, &gpu->buffers, buffer.id, "buffer", call);
}

gpu_texture *gpu_get_texture(kd_gpu *gpu, kd_gpu_texture texture, const char *call)
{
    return get(gpu, &gpu->textures, texture.id, "texture", call);
}

gpu_program *gpu_get_program(kd_gpu *gpu, kd_gpu_program program, const char *call)
{
    return get(gpu, &gpu->programs, program.id, "program", call);
}

gpu_target *gpu_get_target(kd_gpu *gpu, kd_gpu_target target, const char *call)
{
    return get(gpu, &gpu->targets, target.id, "target", call);
}

gpu_readback *gpu_get_readback(kd_gpu *gpu, kd_gpu_readback readback, const char *call)
{
    return get(gpu, &gpu->readbacks, readback.id, "readback", call);
}

bool gpu_range_fits(kd_gpu *gpu, const gpu_buffer *buffer, size_t offset, size_t size, const char *call)
{
    if (offset <= buffer->size && size <= buffer->size - offset)
        return true;
    gpu_complain(gpu, "%s: bytes %zu to %zu lie outside of buffer %s (%zu bytes)", call, offset,
                 offset + size, buffer->name, buffer->size);
    return false;
}
