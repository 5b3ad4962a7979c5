/* Timestamps: a ring of query objects, one set a frame, read when all of a frame have arrived. GPU time is
 * moved onto the CPU's monotonic clock by a difference that is measured now and then, as the clocks drift. */

#include <assert.h>

#include "runtime/gpu/internal.h"

enum { FRAMES_BETWEEN_CORRELATIONS = 64, CORRELATION_TRIES = 3 };

/* Keep the try during which the CPU waited least: it bounds the error best. */
static void correlate(kd_gpu *gpu)
{
    uint64_t shortest = UINT64_MAX;
    for (int i = 0; i < CORRELATION_TRIES; i++) {
        GLint64 gpu_ns = 0;
        uint64_t before = kd_clock_ns();
        gpu->gl.GetInteger64v(GL_TIMESTAMP, &gpu_ns);
        uint64_t after = kd_clock_ns();
        if (after - before >= shortest)
            continue;
        shortest = after - before;
        gpu->timers.cpu_minus_gpu_ns = (int64_t)(before + shortest / 2) - gpu_ns;
    }
}

void gpu_timers_init(kd_gpu *gpu)
{
    for (uint32_t i = 0; i < GPU_TIMER_FRAMES; i++)
        gpu->timers.frames[i] = UINT64_MAX;
    if (!gpu->info.timestamp_bits)
        return;
    for (uint32_t i = 0; i < GPU_TIMER_FRAMES; i++)
        gpu->gl.CreateQueries(GL_TIMESTAMP, KD_GPU_TIMER_SLOTS, gpu->timers.queries[i]);
    correlate(gpu);
}

void kd_gpu_timestamp(kd_gpu *gpu, uint32_t slot)
{
    gpu_timers *timers = &gpu->timers;
    uint32_t set = (uint32_t)(gpu->frame % GPU_TIMER_FRAMES);
    assert(slot < KD_GPU_TIMER_SLOTS);
    if (!gpu->info.timestamp_bits || slot >= KD_GPU_TIMER_SLOTS)
        return;
    if (timers->frames[set] != gpu->frame) {
        for (uint32_t i = 0; i < KD_GPU_TIMER_SLOTS; i++)
            timers->used[set][i] = false;
        timers->frames[set] = gpu->frame;
    }
    gpu->gl.QueryCounter(timers->queries[set][slot], GL_TIMESTAMP);
    timers->used[set][slot] = true;
}

void gpu_timers_end_frame(kd_gpu *gpu)
{
    if (gpu->info.timestamp_bits &&
        gpu->frame % FRAMES_BETWEEN_CORRELATIONS == FRAMES_BETWEEN_CORRELATIONS - 1)
        correlate(gpu);
}

static bool has_arrived(kd_gpu *gpu, uint32_t set)
{
    for (uint32_t i = 0; i < KD_GPU_TIMER_SLOTS; i++) {
        GLint available = GL_FALSE;
        if (!gpu->timers.used[set][i])
            continue;
        gpu->gl.GetQueryObjectiv(gpu->timers.queries[set][i], GL_QUERY_RESULT_AVAILABLE, &available);
        if (!available)
            return false;
    }
    return true;
}

static void read_set(kd_gpu *gpu, uint32_t set, uint64_t *ns, uint32_t slot_count)
{
    for (uint32_t i = 0; i < slot_count; i++) {
        GLuint64 gpu_ns = 0;
        ns[i] = 0;
        if (i >= KD_GPU_TIMER_SLOTS || !gpu->timers.used[set][i])
            continue;
        gpu->gl.GetQueryObjectui64v(gpu->timers.queries[set][i], GL_QUERY_RESULT, &gpu_ns);
        ns[i] = (uint64_t)((int64_t)gpu_ns + gpu->timers.cpu_minus_gpu_ns);
    }
}

bool kd_gpu_read_frame_timestamps(kd_gpu *gpu, uint64_t frame, uint64_t *ns, uint32_t slot_count)
{
    uint32_t set = (uint32_t)(frame % GPU_TIMER_FRAMES);
    if (gpu->timers.frames[set] != frame || frame >= gpu->frame || !has_arrived(gpu, set))
        return false;
    read_set(gpu, set, ns, slot_count);
    return true;
}

uint64_t kd_gpu_read_timestamps(kd_gpu *gpu, uint64_t *ns, uint32_t slot_count)
{
    for (uint64_t back = 1; back <= GPU_TIMER_FRAMES && back <= gpu->frame; back++)
        if (kd_gpu_read_frame_timestamps(gpu, gpu->frame - back, ns, slot_count))
            return gpu->frame - back;
    return UINT64_MAX;
}

void gpu_timers_fini(kd_gpu *gpu)
{
    for (uint32_t i = 0; gpu->info.timestamp_bits && i < GPU_TIMER_FRAMES; i++)
        gpu->gl.DeleteQueries(KD_GPU_TIMER_SLOTS, gpu->timers.queries[i]);
}
