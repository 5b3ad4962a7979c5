#include "runtime/app/timing.h"

#include <stdlib.h>

#include "runtime/core/log.h"

/* ---- hooks ---- */

static bool on_gpu(const app_timing *t, uint32_t system) {
    return kd_schedule_system(t->schedule, system)->where == KD_ON_GPU;
}

static bool has_slots(uint32_t system) {
    return system * 2 + 1 < KD_GPU_TIMER_SLOTS;
}

static void begin(void *user, uint32_t system, uint32_t worker) {
    app_timing *t = user;
    if (on_gpu(t, system)) {
        kd_gpu_push_group(t->gpu, kd_schedule_system(t->schedule, system)->name);
        if (t->mode == APP_TIMING_SYNC)
            kd_gpu_finish(t->gpu);
        if (t->mode == APP_TIMING_STAMPS && has_slots(system))
            kd_gpu_timestamp(t->gpu, system * 2);
    }
    if (t->mode != APP_TIMING_OFF)
        kd_profile_begin(t->profile, system, worker);
}

static void end(void *user, uint32_t system, uint32_t worker) {
    app_timing *t = user;
    bool gpu = on_gpu(t, system);
    if (gpu && t->mode == APP_TIMING_SYNC)
        kd_gpu_finish(t->gpu);
    if (gpu && t->mode == APP_TIMING_STAMPS && has_slots(system))
        kd_gpu_timestamp(t->gpu, system * 2 + 1);
    if (t->mode != APP_TIMING_OFF)
        kd_profile_end(t->profile, system, worker);
    if (gpu)
        kd_gpu_pop_group(t->gpu);
}

/* One row a use: what a reader will do, and the barrier that makes writes visible to it. */
static void barrier(void *user, kd_gpu *gpu, uint32_t uses) {
    static const struct {
        uint32_t uses, barriers;
    } rows[] = {
        {KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE, KD_BARRIER_STORAGE},
        {KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE, KD_BARRIER_IMAGE},
        {KD_USE_SAMPLED, KD_BARRIER_TEXTURE},
        {KD_USE_VERTEX, KD_BARRIER_VERTEX},
        {KD_USE_INDEX, KD_BARRIER_INDEX},
        {KD_USE_INDIRECT, KD_BARRIER_INDIRECT},
        {KD_USE_UNIFORM, KD_BARRIER_UNIFORM},
        {KD_USE_TARGET, KD_BARRIER_TARGET},
        {KD_USE_COPY_READ | KD_USE_COPY_WRITE, KD_BARRIER_BUFFER_UPDATE | KD_BARRIER_TEXTURE_UPDATE},
    };
    uint32_t barriers = 0;
    (void)user;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        barriers |= uses & rows[i].uses ? rows[i].barriers : 0;
    kd_gpu_barrier(gpu, barriers);
}

/* ---- frames ---- */

static kd_profile *make_profile(kd_schedule *s) {
    uint32_t count = kd_schedule_count(s);
    kd_profile_system *systems = calloc(count + 1, sizeof *systems);
    if (!systems)
        return NULL;
    for (uint32_t i = 0; i < count; i++) {
        const kd_system_desc *d = kd_schedule_system(s, i);
        systems[i] = (kd_profile_system){
            .name = d->name, .phase = kd_phase_name(d->phase), .gpu = d->where == KD_ON_GPU};
    }
    kd_profile *profile = kd_profile_make(systems, count);
    free(systems);
    return profile;
}

kd_status app_timing_open(app_timing *t, kd_schedule *s, kd_gpu *gpu, app_timing_mode mode) {
    *t = (app_timing){.schedule = s, .gpu = gpu, .mode = mode, .newest_stamps = UINT64_MAX};
    t->profile = make_profile(s);
    if (!t->profile)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_profile_set_clock(t->profile,
                         mode == APP_TIMING_SYNC ? "finishing each (--profile-sync)" : "GPU timestamps");
    kd_schedule_set_hooks(s, &(kd_schedule_hooks){.begin = begin, .end = end, .barrier = barrier, .user = t});
    return KD_OK;
}

void app_timing_frame_begin(app_timing *t) {
    kd_profile_frame_begin(t->profile);
}

/* Feed what the newest frame's timestamps say, once a frame. */
static void take_stamps(app_timing *t) {
    uint64_t ns[KD_GPU_TIMER_SLOTS];
    uint64_t frame = kd_gpu_read_timestamps(t->gpu, ns, KD_GPU_TIMER_SLOTS);
    if (frame == UINT64_MAX || frame == t->newest_stamps)
        return;
    t->newest_stamps = frame;
    for (uint32_t i = 0; i < kd_schedule_count(t->schedule) && has_slots(i); i++)
        if (on_gpu(t, i) && ns[i * 2] && ns[i * 2 + 1] >= ns[i * 2])
            kd_profile_gpu(t->profile, i, ns[i * 2 + 1] - ns[i * 2]);
}

void app_timing_frame_end(app_timing *t) {
    if (t->mode == APP_TIMING_STAMPS)
        take_stamps(t);
    kd_profile_frame_end(t->profile);
    for (uint32_t i = 0; t->mode != APP_TIMING_OFF && i < kd_schedule_count(t->schedule); i++)
        kd_profile_bytes(t->profile, i, kd_schedule_bytes_moved(t->schedule, i));
}

void app_timing_finish(app_timing *t) {
    for (uint32_t i = 0; i < kd_schedule_count(t->schedule); i++) {
        kd_system_statistics s = kd_schedule_statistics(t->schedule, i);
        kd_profile_count(t->profile, i,
                         &(kd_profile_counts){s.runs, s.disabled, s.not_due, s.refused, s.rows});
    }
}

void app_timing_close(app_timing *t) {
    kd_profile_destroy(t->profile);
    *t = (app_timing){0};
}
