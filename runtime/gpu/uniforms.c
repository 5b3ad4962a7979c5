/* The ring of uniforms: one mapped buffer, split into a part for each of the frames in flight. Before a part
 * is written again its fence is waited for. When a part is full, a ring of twice the size takes over at once;
 * the old one is deleted some frames later, so that what is bound from it stays. */

#include <assert.h>
#include <string.h>

#include "runtime/gpu/internal.h"

static const GLbitfield map_flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
static const size_t first_frame_bytes = 256 << 10;
static const GLuint64 patience_ns = 10000000000u; /* a frame that takes longer has hung the GPU */

static bool make_ring(kd_gpu *gpu, size_t frame_bytes)
{
    gpu_uniforms *ring = &gpu->uniforms;
    GLsizeiptr size = (GLsizeiptr)(frame_bytes * GPU_FRAMES);
    GLuint gl = 0;
    gpu_drain_errors(gpu);
    gpu->gl.CreateBuffers(1, &gl);
    gpu->gl.NamedBufferStorage(gl, size, NULL, map_flags);
    char *mapped = gpu->gl.MapNamedBufferRange(gl, 0, size, map_flags);
    if (!mapped || gpu->gl.GetError() != GL_NO_ERROR) {
        gpu->gl.DeleteBuffers(1, &gl);
        return false;
    }
    ring->gl = gl;
    ring->mapped = mapped;
    ring->frame_bytes = frame_bytes;
    ring->used = 0;
    return true;
}

bool gpu_uniforms_init(kd_gpu *gpu)
{
    GLint alignment = gpu->info.uniform_alignment, max_block = 0;
    gpu->gl.GetIntegerv(GL_MAX_UNIFORM_BLOCK_SIZE, &max_block);
    gpu->uniforms.alignment = alignment > 16 ? (size_t)alignment : 16;
    gpu->uniforms.max_block = (size_t)max_block;
    return make_ring(gpu, first_frame_bytes);
}

static bool grow(kd_gpu *gpu, size_t size)
{
    gpu_uniforms *ring = &gpu->uniforms;
    gpu_retired old = {ring->gl, gpu->frame};
    size_t frame_bytes = ring->frame_bytes * 2;
    while (frame_bytes < size)
        frame_bytes *= 2;
    if (ring->retired_count == sizeof ring->retired / sizeof ring->retired[0] || !make_ring(gpu, frame_bytes))
        return false;
    ring->retired[ring->retired_count++] = old;
    return true;
}

void kd_gpu_bind_uniform(kd_gpu *gpu, uint32_t binding, const void *data, size_t size)
{
    gpu_uniforms *ring = &gpu->uniforms;
    assert(data && size);
    if (size > ring->max_block) {
        gpu_complain(gpu, "bind_uniform: %zu bytes at binding %u (the driver takes %zu)", size, binding,
                     ring->max_block);
        return;
    }
    if (ring->used + size > ring->frame_bytes && !grow(gpu, size)) {
        gpu_complain(gpu, "bind_uniform: no memory for more than %zu bytes of uniforms a frame",
                     ring->frame_bytes);
        return;
    }
    size_t offset = ring->slot * ring->frame_bytes + ring->used;
    memcpy(ring->mapped + offset, data, size);
    gpu->gl.BindBufferRange(GL_UNIFORM_BUFFER, binding, ring->gl, (GLintptr)offset, (GLsizeiptr)size);
    ring->used = (ring->used + size + ring->alignment - 1) / ring->alignment * ring->alignment;
}

/* Delete the rings that no frame in flight can still read. */
static void delete_retired(kd_gpu *gpu)
{
    gpu_uniforms *ring = &gpu->uniforms;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < ring->retired_count; i++) {
        if (gpu->frame < ring->retired[i].frame + GPU_FRAMES)
            ring->retired[kept++] = ring->retired[i];
        else
            gpu->gl.DeleteBuffers(1, &ring->retired[i].gl);
    }
    ring->retired_count = kept;
}

void gpu_uniforms_end_frame(kd_gpu *gpu)
{
    gpu_uniforms *ring = &gpu->uniforms;
    ring->fences[ring->slot] = gpu->gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    ring->slot = (ring->slot + 1) % GPU_FRAMES;
    ring->used = 0;
    delete_retired(gpu);
    GLsync fence = ring->fences[ring->slot];
    if (!fence)
        return;
    GLenum state = gpu->gl.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, patience_ns);
    if (state == GL_TIMEOUT_EXPIRED || state == GL_WAIT_FAILED)
        gpu_complain(gpu, "the GPU does not finish its frames; it may be lost");
    gpu->gl.DeleteSync(fence);
    ring->fences[ring->slot] = NULL;
}

void gpu_uniforms_fini(kd_gpu *gpu)
{
    gpu_uniforms *ring = &gpu->uniforms;
    for (uint32_t i = 0; i < GPU_FRAMES; i++)
        if (ring->fences[i])
            gpu->gl.DeleteSync(ring->fences[i]);
    for (uint32_t i = 0; i < ring->retired_count; i++)
        gpu->gl.DeleteBuffers(1, &ring->retired[i].gl);
    if (ring->gl)
        gpu->gl.DeleteBuffers(1, &ring->gl);
}
