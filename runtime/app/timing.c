#include "runtime/app/timing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"

#define MAX_SAMPLES                                                                                          \
    65536 /* of one system: later ones are left out, so that a long run needs no more memory */

/* ---- samples ---- */

static void add_sample(app_samples *s, double ms) {
    if (s->count == s->capacity) {
        uint32_t capacity = s->capacity ? s->capacity * 2 : 128;
        float *grown = capacity <= MAX_SAMPLES ? realloc(s->ms, capacity * sizeof *grown) : NULL;
        if (!grown)
            return;
        s->ms = grown;
        s->capacity = capacity;
    }
    s->ms[s->count++] = (float)ms;
}

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

app_summary app_summarise(const app_samples *samples) {
    uint32_t n = samples->count;
    float *sorted = n ? malloc(n * sizeof *sorted) : NULL;
    if (!sorted)
        return (app_summary){0};
    memcpy(sorted, samples->ms, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare_floats);
    double middle = n % 2 ? (double)sorted[n / 2] : ((double)sorted[n / 2 - 1] + (double)sorted[n / 2]) / 2;
    app_summary out = {n, middle, (double)sorted[(95 * (uint64_t)n + 99) / 100 - 1], (double)sorted[n - 1]};
    free(sorted);
    return out;
}

/* ---- hooks ---- */

static bool on_gpu(const app_timing *t, uint32_t system) {
    return kd_schedule_system(t->schedule, system)->where == KD_ON_GPU;
}

static bool has_slots(uint32_t system) {
    return system * 2 + 1 < KD_GPU_TIMER_SLOTS;
}

static void begin(void *user, uint32_t system, uint32_t worker) {
    app_timing *t = user;
    (void)worker;
    if (on_gpu(t, system)) {
        kd_gpu_push_group(t->gpu, kd_schedule_system(t->schedule, system)->name);
        if (t->mode == APP_TIMING_SYNC)
            kd_gpu_finish(t->gpu);
        if (t->mode == APP_TIMING_STAMPS && has_slots(system))
            kd_gpu_timestamp(t->gpu, system * 2);
    }
    t->began_ns[system] = kd_clock_ns();
}

static void end(void *user, uint32_t system, uint32_t worker) {
    app_timing *t = user;
    const kd_system_desc *desc = kd_schedule_system(t->schedule, system);
    bool gpu = on_gpu(t, system);
    (void)worker;
    if (gpu && t->mode == APP_TIMING_SYNC)
        kd_gpu_finish(t->gpu);
    if (gpu && t->mode == APP_TIMING_STAMPS && has_slots(system))
        kd_gpu_timestamp(t->gpu, system * 2 + 1);
    if (t->mode == APP_TIMING_SYNC || (t->mode == APP_TIMING_STAMPS && !gpu))
        add_sample(&t->systems[system], (double)(kd_clock_ns() - t->began_ns[system]) * 1e-6);
    if (t->mode != APP_TIMING_OFF && desc->bytes_moved) {
        kd_system_context context = t->moved;
        context.gpu = gpu ? t->gpu : NULL;
        context.user = desc->user;
        t->bytes[system] = desc->bytes_moved(&context);
    }
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

kd_status app_timing_open(app_timing *t, kd_schedule *s, kd_world *w, kd_gpu *gpu, kd_jobs *jobs,
                          app_timing_mode mode) {
    uint32_t count = kd_schedule_count(s);
    *t = (app_timing){
        .schedule = s, .gpu = gpu, .mode = mode, .system_count = count, .newest_stamps = UINT64_MAX};
    t->moved = (kd_system_context){.world = w, .jobs = jobs};
    t->began_ns = calloc(count + 1, sizeof *t->began_ns);
    t->systems = calloc(count + 1, sizeof *t->systems);
    t->bytes = calloc(count + 1, sizeof *t->bytes);
    if (!t->began_ns || !t->systems || !t->bytes)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_schedule_set_hooks(s, &(kd_schedule_hooks){.begin = begin, .end = end, .barrier = barrier, .user = t});
    return KD_OK;
}

void app_timing_frame_begin(app_timing *t) {
    t->frame_began_ns = kd_clock_ns();
}

/* Add what the newest frame's timestamps say, once a frame. */
static void take_stamps(app_timing *t) {
    uint64_t ns[KD_GPU_TIMER_SLOTS];
    uint64_t frame = kd_gpu_read_timestamps(t->gpu, ns, KD_GPU_TIMER_SLOTS);
    if (frame == UINT64_MAX || frame == t->newest_stamps)
        return;
    t->newest_stamps = frame;
    for (uint32_t i = 0; i < t->system_count && has_slots(i); i++)
        if (on_gpu(t, i) && ns[i * 2] && ns[i * 2 + 1] >= ns[i * 2])
            add_sample(&t->systems[i], (double)(ns[i * 2 + 1] - ns[i * 2]) * 1e-6);
}

void app_timing_frame_end(app_timing *t) {
    if (t->mode == APP_TIMING_STAMPS)
        take_stamps(t);
    add_sample(&t->frames, (double)(kd_clock_ns() - t->frame_began_ns) * 1e-6);
}

void app_timing_close(app_timing *t) {
    for (uint32_t i = 0; t->systems && i < t->system_count; i++)
        free(t->systems[i].ms);
    free(t->systems);
    free(t->began_ns);
    free(t->bytes);
    free(t->frames.ms);
    *t = (app_timing){0};
}

void app_timing_print(const app_timing *t) {
    app_summary frame = app_summarise(&t->frames);
    printf("%-22s %-15s %-5s %10s %10s %10s %10s\n", "system", "phase", "where", "median ms", "p95 ms",
           "max ms", "MB moved");
    for (uint32_t i = 0; i < t->system_count; i++) {
        const kd_system_desc *d = kd_schedule_system(t->schedule, i);
        app_summary s = app_summarise(&t->systems[i]);
        printf("%-22s %-15s %-5s %10.3f %10.3f %10.3f %10.1f\n", d->name, kd_phase_name(d->phase),
               d->where == KD_ON_GPU ? "gpu" : "cpu", s.median, s.p95, s.max, (double)t->bytes[i] * 1e-6);
    }
    printf("%-22s %-15s %-5s %10.3f %10.3f %10.3f\n", "frame", "", "", frame.median, frame.p95, frame.max);
    printf("%u frames; GPU systems timed by %s\n", frame.count,
           t->mode == APP_TIMING_SYNC ? "finishing each (--profile-sync)" : "GPU timestamps");
}
