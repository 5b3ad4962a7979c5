/* What passes bind and dispatch. Bindings that GL already has are left out. */

#include <assert.h>

#include "runtime/gpu/internal.h"

static bool is_aligned(kd_gpu *gpu, const gpu_buffer *buffer, size_t offset, int alignment, const char *call)
{
    if (alignment <= 1 || offset % (size_t)alignment == 0)
        return true;
    gpu_complain(gpu, "%s: offset %zu into %s is no multiple of the driver's %d bytes", call, offset,
                 buffer->name, alignment);
    return false;
}

void kd_gpu_bind_storage(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer handle)
{
    kd_gpu_bind_storage_range(gpu, binding, handle, 0, kd_gpu_buffer_size(gpu, handle));
}

/* Complains when the range cannot be bound. Returns NULL then. */
static const gpu_buffer *check_storage(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer handle, size_t offset,
                                       size_t size)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, handle, "bind_storage");
    if (!buffer || !gpu_range_fits(gpu, buffer, offset, size, "bind_storage") ||
        !is_aligned(gpu, buffer, offset, gpu->info.storage_alignment, "bind_storage"))
        return NULL;
    if (binding >= (uint32_t)gpu->max_storage_bindings || !size || (int64_t)size > gpu->info.max_ssbo_bytes) {
        gpu_complain(gpu,
                     "bind_storage: %zu bytes of %s at binding %u (there are %d bindings of %lld bytes); "
                     "passes that use "
                     "it are left out",
                     size, buffer->name, binding, gpu->max_storage_bindings,
                     (long long)gpu->info.max_ssbo_bytes);
        return NULL;
    }
    return buffer;
}

/* What was bound there before must not be taken for what was asked for. */
static void refuse_storage(kd_gpu *gpu, uint32_t binding)
{
    if (binding >= (uint32_t)gpu->max_storage_bindings)
        return;
    gpu->gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, 0);
    gpu->storage[binding] = (gpu_storage_binding){0};
    gpu->refused_storage |= 1u << binding;
}

void kd_gpu_bind_storage_range(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer handle, size_t offset,
                               size_t size)
{
    const gpu_buffer *buffer = check_storage(gpu, binding, handle, offset, size);
    if (!buffer) {
        refuse_storage(gpu, binding);
        return;
    }
    gpu_storage_binding *cached = &gpu->storage[binding];
    if (cached->id == handle.id && cached->offset == offset && cached->size == size)
        return;
    gpu->gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, buffer->gl, (GLintptr)offset,
                            (GLsizeiptr)size);
    *cached = (gpu_storage_binding){handle.id, offset, size};
    gpu->refused_storage &= ~(1u << binding);
}

void kd_gpu_bind_uniform_buffer(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer handle, size_t offset,
                                size_t size)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, handle, "bind_uniform_buffer");
    if (buffer && gpu_range_fits(gpu, buffer, offset, size, "bind_uniform_buffer") &&
        is_aligned(gpu, buffer, offset, gpu->info.uniform_alignment, "bind_uniform_buffer"))
        gpu->gl.BindBufferRange(GL_UNIFORM_BUFFER, binding, buffer->gl, (GLintptr)offset, (GLsizeiptr)size);
}

void kd_gpu_bind_texture(kd_gpu *gpu, uint32_t unit, kd_gpu_texture handle)
{
    gpu_texture *texture = gpu_get_texture(gpu, handle, "bind_texture");
    if (!texture || (unit < GPU_MAX_TEXTURES && gpu->texture_units[unit] == handle.id))
        return;
    if (unit >= (uint32_t)gpu->max_texture_units) {
        gpu_complain(gpu, "bind_texture: unit %u for %s (the driver has %d)", unit, texture->name,
                     gpu->max_texture_units);
        return;
    }
    gpu->gl.BindTextureUnit(unit, texture->gl);
    if (unit < GPU_MAX_TEXTURES)
        gpu->texture_units[unit] = handle.id;
}

void kd_gpu_bind_image(kd_gpu *gpu, uint32_t unit, kd_gpu_texture handle, uint32_t level,
                       kd_image_access access, kd_texture_format format)
{
    static const GLenum modes[] = {GL_READ_ONLY, GL_WRITE_ONLY, GL_READ_WRITE};
    gpu_texture *texture = gpu_get_texture(gpu, handle, "bind_image");
    const gpu_format *row = gpu_get_format(format);
    if (!texture)
        return;
    if (!row->is_image || row->texel_bytes != gpu_get_format(texture->format)->texel_bytes ||
        level >= texture->levels || unit >= (uint32_t)gpu->max_image_units) {
        gpu_complain(gpu, "bind_image: level %u of %s as %s at unit %u is not possible", level, texture->name,
                     row->name, unit);
        return;
    }
    GLboolean layered =
        texture->target == GL_TEXTURE_2D || texture->target == GL_TEXTURE_BUFFER ? GL_FALSE : GL_TRUE;
    gpu->gl.BindImageTexture(unit, texture->gl, (GLint)level, layered, 0, modes[access], row->internal);
}

void kd_gpu_dispatch(kd_gpu *gpu, kd_gpu_program program, uint32_t x, uint32_t y, uint32_t z)
{
    if (!x || !y || !z || !gpu_use_program(gpu, program, true, "dispatch"))
        return;
    if (x > gpu->max_groups[0] || y > gpu->max_groups[1] || z > gpu->max_groups[2]) {
        gpu_complain(gpu, "dispatch: %u x %u x %u groups are more than the driver takes", x, y, z);
        return;
    }
    gpu->gl.DispatchCompute(x, y, z);
}

void kd_gpu_dispatch_linear(kd_gpu *gpu, kd_gpu_program program, uint32_t groups)
{
    /* Drivers need not take more groups on an axis, and y takes no more even where x does. */
    const uint32_t row = 65535;
    if (!groups)
        return;
    uint32_t rows = groups / row + (groups % row != 0);
    kd_gpu_dispatch(gpu, program, groups / rows + (groups % rows != 0), rows, 1);
}

void kd_gpu_dispatch_indirect(kd_gpu *gpu, kd_gpu_program program, kd_gpu_buffer args, size_t offset)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, args, "dispatch_indirect");
    assert(offset % 4 == 0);
    if (!buffer || !gpu_range_fits(gpu, buffer, offset, 12, "dispatch_indirect") ||
        !gpu_use_program(gpu, program, true, "dispatch_indirect"))
        return;
    gpu->gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffer->gl);
    gpu->gl.DispatchComputeIndirect((GLintptr)offset);
}

void kd_gpu_barrier(kd_gpu *gpu, uint32_t barriers)
{
    static const struct {
        uint32_t barrier;
        GLbitfield bit;
    } rows[] = {
        {KD_BARRIER_STORAGE, GL_SHADER_STORAGE_BARRIER_BIT},
        {KD_BARRIER_IMAGE, GL_SHADER_IMAGE_ACCESS_BARRIER_BIT},
        {KD_BARRIER_TEXTURE, GL_TEXTURE_FETCH_BARRIER_BIT},
        {KD_BARRIER_VERTEX, GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT},
        {KD_BARRIER_INDEX, GL_ELEMENT_ARRAY_BARRIER_BIT},
        {KD_BARRIER_INDIRECT, GL_COMMAND_BARRIER_BIT},
        {KD_BARRIER_UNIFORM, GL_UNIFORM_BARRIER_BIT},
        {KD_BARRIER_TARGET, GL_FRAMEBUFFER_BARRIER_BIT},
        {KD_BARRIER_BUFFER_UPDATE, GL_BUFFER_UPDATE_BARRIER_BIT},
        {KD_BARRIER_TEXTURE_UPDATE, GL_TEXTURE_UPDATE_BARRIER_BIT},
    };
    GLbitfield bits = 0;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (barriers & rows[i].barrier)
            bits |= rows[i].bit;
    if (bits)
        gpu->gl.MemoryBarrier(bits);
}

void kd_gpu_finish(kd_gpu *gpu)
{
    gpu->gl.Finish();
}

void kd_gpu_push_group(kd_gpu *gpu, const char *name)
{
    if (gpu->debug)
        gpu->gl.PushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, name);
}

void kd_gpu_pop_group(kd_gpu *gpu)
{
    if (gpu->debug)
        gpu->gl.PopDebugGroup();
}

void kd_gpu_set_pass_hook(kd_gpu *gpu, void (*pass)(void *user, uint32_t program, const char *name),
                          void *user)
{
    gpu->pass = pass;
    gpu->pass_user = user;
}

void kd_gpu_end_frame(kd_gpu *gpu)
{
    gpu_uniforms_end_frame(gpu);
    gpu_timers_end_frame(gpu);
    gpu->gl.Flush();
    gpu_drain_errors(gpu);
    gpu->frame++;
}
