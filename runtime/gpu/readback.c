/* Readback without a stall: a ring of areas in one mapped buffer; a fence behind each copy says when it may
 * be read. The area handed out by the last poll stays the caller's until the next poll. */

#include <assert.h>
#include <string.h>

#include "runtime/gpu/internal.h"

static const GLbitfield map_flags = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
static const GLuint64 patience_ns = 10000000000u; /* a copy that takes longer has hung the GPU */

enum { AREA_ALIGNMENT = 256 };

kd_gpu_readback kd_gpu_make_readback(kd_gpu *gpu, size_t size, uint32_t depth, const char *name)
{
    assert(gpu && size && depth <= GPU_MAX_AREAS);
    gpu_readback made = {.depth = depth ? depth : 3}, *readback;
    made.area_bytes = (size + AREA_ALIGNMENT - 1) / AREA_ALIGNMENT * AREA_ALIGNMENT;
    GLsizeiptr bytes = (GLsizeiptr)(made.area_bytes * made.depth);
    gpu_copy_name(made.name, name, "readback");
    gpu_drain_errors(gpu);
    gpu->gl.CreateBuffers(1, &made.gl);
    gpu->gl.NamedBufferStorage(made.gl, bytes, NULL, map_flags | GL_CLIENT_STORAGE_BIT);
    made.mapped = gpu->gl.MapNamedBufferRange(made.gl, 0, bytes, map_flags);
    uint32_t id = made.mapped && gpu->gl.GetError() == GL_NO_ERROR
                      ? gpu_pool_add(&gpu->readbacks, (void **)&readback)
                      : 0;
    if (!id) {
        gpu->gl.DeleteBuffers(1, &made.gl);
        gpu_fail(gpu, "readback %s: the driver refused %u areas of %zu bytes; ask for less", made.name,
                 made.depth, size);
        return (kd_gpu_readback){0};
    }
    *readback = made;
    gpu->bytes += (size_t)bytes;
    gpu_label(gpu, GL_BUFFER, made.gl, made.name);
    return (kd_gpu_readback){id};
}

void gpu_release_readback(kd_gpu *gpu, gpu_readback *readback)
{
    for (uint32_t i = 0; i < readback->depth; i++)
        if (readback->areas[i].fence)
            gpu->gl.DeleteSync(readback->areas[i].fence);
    gpu->gl.DeleteBuffers(1, &readback->gl);
    gpu->bytes -= readback->area_bytes * readback->depth;
}

void kd_gpu_destroy_readback(kd_gpu *gpu, kd_gpu_readback handle)
{
    gpu_readback *readback = handle.id ? gpu_get_readback(gpu, handle, "destroy_readback") : NULL;
    if (!readback)
        return;
    gpu_release_readback(gpu, readback);
    gpu_pool_remove(&gpu->readbacks, handle.id);
}

/* Take the next area for `size` bytes. Returns its index, or -1 with *status set. */
static int begin_copy(kd_gpu *gpu, gpu_readback *readback, size_t size, kd_status *status)
{
    if (size > readback->area_bytes) {
        gpu_complain(gpu, "readback %s: %zu bytes do not fit an area of %zu", readback->name, size,
                     readback->area_bytes);
        *status = KD_TOO_LARGE;
        return -1;
    }
    if (readback->count + (readback->held ? 1 : 0) >= readback->depth) {
        *status = KD_OUT_OF_RANGE;
        return -1;
    }
    *status = KD_OK;
    return (int)((readback->first + readback->count) % readback->depth);
}

static void end_copy(kd_gpu *gpu, gpu_readback *readback, int index, size_t size, uint64_t tag)
{
    gpu_area *area = &readback->areas[index];
    area->fence = gpu->gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    area->tag = tag;
    area->size = size;
    area->frame = gpu->frame;
    readback->count++;
}

kd_status kd_gpu_readback_buffer(kd_gpu *gpu, kd_gpu_readback handle, kd_gpu_buffer from, size_t offset,
                                 size_t size, uint64_t tag)
{
    gpu_readback *readback = gpu_get_readback(gpu, handle, "readback_buffer");
    gpu_buffer *buffer = readback ? gpu_get_buffer(gpu, from, "readback_buffer") : NULL;
    kd_status status;
    if (!buffer || !gpu_range_fits(gpu, buffer, offset, size, "readback_buffer"))
        return KD_GPU;
    int index = begin_copy(gpu, readback, size, &status);
    if (index < 0)
        return status;
    gpu->gl.CopyNamedBufferSubData(buffer->gl, readback->gl, (GLintptr)offset,
                                   (GLintptr)((size_t)index * readback->area_bytes), (GLsizeiptr)size);
    end_copy(gpu, readback, index, size, tag);
    return KD_OK;
}

kd_status kd_gpu_readback_texture(kd_gpu *gpu, kd_gpu_readback handle, kd_gpu_texture from, uint32_t level,
                                  uint64_t tag)
{
    gpu_readback *readback = gpu_get_readback(gpu, handle, "readback_texture");
    gpu_texture *texture = readback ? gpu_get_texture(gpu, from, "readback_texture") : NULL;
    kd_status status;
    if (!texture || level >= texture->levels || texture->target == GL_TEXTURE_BUFFER)
        return KD_GPU;
    const gpu_format *format = gpu_get_format(texture->format);
    size_t size = gpu_level_bytes(texture, level);
    int index = begin_copy(gpu, readback, size, &status);
    if (index < 0)
        return status;
    gpu->gl.BindBuffer(GL_PIXEL_PACK_BUFFER, readback->gl);
    gpu->gl.GetTextureImage(texture->gl, (GLint)level, format->format, format->type,
                            (GLsizei)(size < INT32_MAX ? size : INT32_MAX),
                            (void *)(uintptr_t)((size_t)index * readback->area_bytes));
    gpu->gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    end_copy(gpu, readback, index, size, tag);
    return KD_OK;
}

static bool is_done(kd_gpu *gpu, const gpu_readback *readback, const gpu_area *area, bool wait)
{
    /* A fence of this frame may still lie in the driver's queue; older ones were flushed with their frame. */
    GLbitfield flags = wait || area->frame == gpu->frame ? GL_SYNC_FLUSH_COMMANDS_BIT : 0;
    GLenum state = gpu->gl.ClientWaitSync(area->fence, flags, wait ? patience_ns : 0);
    if (state == GL_WAIT_FAILED || (wait && state == GL_TIMEOUT_EXPIRED)) {
        gpu_complain(gpu, "readback %s: the GPU does not finish; it may be lost", readback->name);
        return false;
    }
    return state != GL_TIMEOUT_EXPIRED;
}

const void *kd_gpu_readback_poll(kd_gpu *gpu, kd_gpu_readback handle, bool wait, uint64_t *tag, size_t *size)
{
    gpu_readback *readback = gpu_get_readback(gpu, handle, "readback_poll");
    if (!readback)
        return NULL;
    readback->held = false;
    if (!readback->count)
        return NULL;
    uint32_t index = readback->first;
    gpu_area *area = &readback->areas[index];
    if (!is_done(gpu, readback, area, wait))
        return NULL;
    gpu->gl.DeleteSync(area->fence);
    area->fence = NULL;
    readback->first = (index + 1) % readback->depth;
    readback->count--;
    readback->held = true;
    if (tag)
        *tag = area->tag;
    if (size)
        *size = area->size;
    return readback->mapped + index * readback->area_bytes;
}
