/* Buffers with immutable storage. A static one is written through a staging copy, so that the driver may keep
 * it in memory that the CPU does not reach. */

#include <assert.h>
#include <string.h>

#include "runtime/gpu/internal.h"

/* Returns 0 when the driver refuses. */
static GLuint make_storage(kd_gpu *gpu, size_t size, const void *data, GLbitfield flags)
{
    GLuint gl = 0;
    gpu_drain_errors(gpu);
    gpu->gl.CreateBuffers(1, &gl);
    gpu->gl.NamedBufferStorage(gl, (GLsizeiptr)size, data, flags);
    if (gpu->gl.GetError() == GL_NO_ERROR)
        return gl;
    gpu->gl.DeleteBuffers(1, &gl);
    return 0;
}

kd_gpu_buffer kd_gpu_make_buffer(kd_gpu *gpu, const kd_gpu_buffer_desc *desc)
{
    assert(gpu && desc && desc->size);
    const char *name = desc->name ? desc->name : "buffer";
    GLbitfield flags = desc->usage == KD_BUFFER_STREAM ? GL_DYNAMIC_STORAGE_BIT : 0;
    GLuint gl = desc->size <= PTRDIFF_MAX ? make_storage(gpu, desc->size, desc->data, flags) : 0;
    if (!gl) {
        gpu_fail(gpu, "buffer %s: the driver refused %zu bytes (%zu in use); ask for less", name, desc->size,
                 gpu->bytes);
        return (kd_gpu_buffer){0};
    }
    gpu_buffer *buffer;
    uint32_t id = gpu_pool_add(&gpu->buffers, (void **)&buffer);
    if (!id) {
        gpu->gl.DeleteBuffers(1, &gl);
        gpu_fail(gpu, "buffer %s: no memory for its handle", name);
        return (kd_gpu_buffer){0};
    }
    buffer->gl = gl;
    buffer->size = desc->size;
    buffer->usage = desc->usage;
    gpu_copy_name(buffer->name, desc->name, "buffer");
    gpu_label(gpu, GL_BUFFER, gl, buffer->name);
    gpu->bytes += desc->size;
    if (desc->zeroed && !desc->data)
        gpu->gl.ClearNamedBufferSubData(gl, GL_R8UI, 0, (GLsizeiptr)desc->size, GL_RED_INTEGER,
                                        GL_UNSIGNED_BYTE, NULL);
    return (kd_gpu_buffer){id};
}

void kd_gpu_destroy_buffer(kd_gpu *gpu, kd_gpu_buffer handle)
{
    gpu_buffer *buffer = handle.id ? gpu_get_buffer(gpu, handle, "destroy_buffer") : NULL;
    if (!buffer)
        return;
    for (uint32_t i = 0; i < GPU_MAX_STORAGE; i++)
        if (gpu->storage[i].id == handle.id)
            gpu->storage[i] = (gpu_storage_binding){0};
    gpu->geometry_known = false;
    gpu->bytes -= buffer->size;
    gpu->gl.DeleteBuffers(1, &buffer->gl);
    gpu_pool_remove(&gpu->buffers, handle.id);
}

size_t kd_gpu_buffer_size(const kd_gpu *gpu, kd_gpu_buffer handle)
{
    const gpu_buffer *buffer = gpu_pool_find(&gpu->buffers, handle.id);
    return buffer ? buffer->size : 0;
}

void kd_gpu_write_buffer(kd_gpu *gpu, kd_gpu_buffer handle, size_t offset, const void *data, size_t size)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, handle, "write_buffer");
    if (!buffer || !size || !gpu_range_fits(gpu, buffer, offset, size, "write_buffer"))
        return;
    if (buffer->usage == KD_BUFFER_STREAM) {
        gpu->gl.NamedBufferSubData(buffer->gl, (GLintptr)offset, (GLsizeiptr)size, data);
        return;
    }
    GLuint staging = make_storage(gpu, size, data, 0);
    if (!staging) {
        gpu_complain(gpu, "write_buffer: no memory to stage %zu bytes for %s", size, buffer->name);
        return;
    }
    gpu->gl.CopyNamedBufferSubData(staging, buffer->gl, 0, (GLintptr)offset, (GLsizeiptr)size);
    gpu->gl.DeleteBuffers(1, &staging);
}

void kd_gpu_fill_buffer(kd_gpu *gpu, kd_gpu_buffer handle, size_t offset, size_t size, uint32_t word)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, handle, "fill_buffer");
    assert(offset % 4 == 0 && size % 4 == 0);
    if (buffer && size && gpu_range_fits(gpu, buffer, offset, size, "fill_buffer"))
        gpu->gl.ClearNamedBufferSubData(buffer->gl, GL_R32UI, (GLintptr)offset, (GLsizeiptr)size,
                                        GL_RED_INTEGER, GL_UNSIGNED_INT, &word);
}

void kd_gpu_copy_buffer(kd_gpu *gpu, kd_gpu_buffer from, size_t from_offset, kd_gpu_buffer to,
                        size_t to_offset, size_t size)
{
    gpu_buffer *source = gpu_get_buffer(gpu, from, "copy_buffer");
    gpu_buffer *target = source ? gpu_get_buffer(gpu, to, "copy_buffer") : NULL;
    if (target && size && gpu_range_fits(gpu, source, from_offset, size, "copy_buffer") &&
        gpu_range_fits(gpu, target, to_offset, size, "copy_buffer"))
        gpu->gl.CopyNamedBufferSubData(source->gl, target->gl, (GLintptr)from_offset, (GLintptr)to_offset,
                                       (GLsizeiptr)size);
}

void kd_gpu_read_buffer(kd_gpu *gpu, kd_gpu_buffer handle, size_t offset, void *out, size_t size)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, handle, "read_buffer");
    if (!buffer || !size || !gpu_range_fits(gpu, buffer, offset, size, "read_buffer")) {
        memset(out, 0, size);
        return;
    }
    gpu->gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gpu->gl.GetNamedBufferSubData(buffer->gl, (GLintptr)offset, (GLsizeiptr)size, out);
}

kd_status kd_gpu_ensure_buffer(kd_gpu *gpu, kd_gpu_buffer *handle, size_t size, size_t keep, const char *name)
{
    gpu_buffer *old = handle->id ? gpu_get_buffer(gpu, *handle, "ensure_buffer") : NULL;
    size_t old_size = old ? old->size : 0;
    kd_gpu_buffer_desc desc = {.size = size, .name = name};
    if (old_size >= size && old_size)
        return KD_OK;
    if (old)
        desc.usage = old->usage;
    kd_gpu_buffer grown = kd_gpu_make_buffer(gpu, &desc);
    if (!grown.id)
        return KD_GPU;
    if (keep > old_size)
        keep = old_size;
    if (keep) {
        gpu->gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        kd_gpu_copy_buffer(gpu, *handle, 0, grown, 0, keep);
    }
    if (old)
        kd_gpu_destroy_buffer(gpu, *handle);
    *handle = grown;
    return KD_OK;
}
