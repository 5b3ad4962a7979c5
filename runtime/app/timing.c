#include "runtime/app/timing.h"

#include <malloc.h>
#include <stdlib.h>

#include "components/render_targets.h"
#include "runtime/core/log.h"

/* ---- hooks ---- */

static bool on_gpu(const app_timing *t, uint32_t system)
{
    return kd_schedule_system(t->schedule, system)->where == KD_ON_GPU;
}

static void begin(void *user, uint32_t system, uint32_t worker)
{
    app_timing *t = user;
    bool gpu = on_gpu(t, system);
    if (t->mode != APP_TIMING_OFF)
        kd_profile_begin(t->profile, system, worker);
    if (gpu)
        kd_gpu_push_group(t->gpu, kd_schedule_system(t->schedule, system)->name);
    if (gpu && t->gpu_timing)
        app_gpu_timing_begin(t->gpu_timing, system);
}

static void end(void *user, uint32_t system, uint32_t worker)
{
    app_timing *t = user;
    bool gpu = on_gpu(t, system);
    if (gpu && t->gpu_timing)
        app_gpu_timing_end(t->gpu_timing, system);
    if (gpu)
        kd_gpu_pop_group(t->gpu);
    if (t->mode != APP_TIMING_OFF)
        kd_profile_end(t->profile, system, worker);
}

/* What the schedule does itself. */
static void own(void *user, bool merge, bool begin)
{
    app_timing_section(user, merge ? APP_ROW_MERGE : APP_ROW_WAIT, begin);
}

/* One row a use: what a reader will do, and the barrier that makes writes visible to it. */
static void barrier(void *user, kd_gpu *gpu, uint32_t uses)
{
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

static const struct {
    const char *name, *phase;
    bool gpu;
} own_rows[APP_ROW_COUNT] = {
    [APP_ROW_SCENARIO] = {"scenario", "script", false},
    [APP_ROW_MERGE] = {"merge_commands", "schedule", false},
    [APP_ROW_WAIT] = {"wait_for_workers", "schedule", false},
    [APP_ROW_END] = {"end_frame", "schedule", false},
    [APP_ROW_GPU_FRAME] = {"gpu_frame", "", true},
    [APP_ROW_GPU_IDLE] = {"gpu_idle", "", true},
};

static kd_profile *make_profile(kd_schedule *s, bool own_rows_too)
{
    uint32_t count = kd_schedule_count(s), more = own_rows_too ? APP_ROW_COUNT : 0;
    kd_profile_system *systems = calloc(count + APP_ROW_COUNT, sizeof *systems);
    if (!systems)
        return NULL;
    for (uint32_t i = 0; i < count; i++) {
        const kd_system_desc *d = kd_schedule_system(s, i);
        systems[i] = (kd_profile_system){
            .name = d->name, .phase = kd_phase_name(d->phase), .gpu = d->where == KD_ON_GPU};
    }
    for (uint32_t i = 0; i < more; i++)
        systems[count + i] =
            (kd_profile_system){.name = own_rows[i].name, .phase = own_rows[i].phase, .gpu = own_rows[i].gpu};
    kd_profile *profile = kd_profile_make(systems, count + more);
    free(systems);
    return profile;
}

/* Follow everything through time: jobs, passes and counters too. */
static kd_status open_trace(app_timing *t, kd_jobs *jobs)
{
    static const char *const names[APP_COUNTER_COUNT] = {
        [APP_COUNTER_VOXELS] = "voxels",         [APP_COUNTER_NODES] = "tree nodes",
        [APP_COUNTER_ENTITIES] = "entities",     [APP_COUNTER_GPU_BYTES] = "GPU bytes",
        [APP_COUNTER_HEAP_BYTES] = "heap bytes", [APP_COUNTER_WORLD_BYTES] = "world bytes",
        [APP_COUNTER_ALLOCATIONS] = "allocations", [APP_COUNTER_ALLOCATED_BYTES] = "allocated bytes"};
    kd_status status = kd_profile_trace(t->profile, kd_jobs_threads(jobs));
    if (status != KD_OK)
        return status;
    for (uint32_t i = 0; i < APP_COUNTER_COUNT; i++)
        t->counters[i] = kd_profile_counter_name(t->profile, names[i]);
    kd_jobs_set_hooks(
        jobs, &(kd_jobs_hooks){.begin = kd_profile_job_begin, .end = kd_profile_job_end, .user = t->profile});
    return KD_OK;
}

kd_status app_timing_open(app_timing *t, const app_timing_desc *desc)
{
    bool on = desc->mode != APP_TIMING_OFF, sync = desc->mode == APP_TIMING_SYNC;
    kd_status status = KD_OK;
    *t = (app_timing){.schedule = desc->schedule,
                      .gpu = desc->gpu,
                      .world = desc->world,
                      .mode = desc->mode,
                      .trace = desc->trace};
    t->first_row = kd_schedule_count(desc->schedule);
    t->profile = make_profile(desc->schedule, on);
    if (!t->profile)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    if (desc->trace)
        status = open_trace(t, desc->jobs);
    if (on && status == KD_OK) {
        t->gpu_timing = app_gpu_timing_make(desc->gpu, t->profile, t->first_row + APP_ROW_GPU_FRAME,
                                            t->first_row + APP_ROW_GPU_IDLE, sync, desc->trace);
        status = t->gpu_timing ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory");
    }
    kd_profile_set_clock(t->profile, sync ? "finishing each (--profile-sync)" : "GPU timestamps");
    kd_schedule_set_hooks(
        desc->schedule,
        &(kd_schedule_hooks){
            .begin = begin, .end = end, .barrier = barrier, .own = on ? own : NULL, .user = t});
    return status;
}

void app_timing_section(app_timing *t, app_timing_row row, bool begins)
{
    if (t->mode == APP_TIMING_OFF)
        return;
    if (begins)
        kd_profile_begin(t->profile, t->first_row + row, KD_GPU_LANE);
    else
        kd_profile_end(t->profile, t->first_row + row, KD_GPU_LANE);
}

void app_timing_frame_begin(app_timing *t)
{
    t->before = kd_allocations_so_far();
    kd_profile_frame_begin(t->profile);
}

/* What the frame took; nothing is fed where the linker counts nothing. */
static kd_allocations count_allocations(app_timing *t)
{
    kd_allocations now = kd_allocations_so_far(),
                   taken = {now.count - t->before.count, now.bytes - t->before.bytes};
    if (now.count)
        kd_profile_allocated(t->profile, taken.count, taken.bytes);
    return taken;
}

static void count_all(app_timing *t, kd_allocations taken)
{
    const kd_tree *tree = kd_singleton(t->world, kd_tree);
    struct mallinfo2 heap = mallinfo2();
    const double values[APP_COUNTER_COUNT] = {
        [APP_COUNTER_VOXELS] = (double)(tree->static_voxels + tree->dynamic_voxels),
        [APP_COUNTER_NODES] = (double)tree->node_count,
        [APP_COUNTER_ENTITIES] = (double)kd_entity_count(t->world),
        [APP_COUNTER_GPU_BYTES] = (double)kd_gpu_bytes(t->gpu),
        [APP_COUNTER_HEAP_BYTES] = (double)(heap.uordblks + heap.hblkhd),
        [APP_COUNTER_WORLD_BYTES] = (double)kd_world_bytes(t->world),
        [APP_COUNTER_ALLOCATIONS] = (double)taken.count,
        [APP_COUNTER_ALLOCATED_BYTES] = (double)taken.bytes,
    };
    for (uint32_t i = 0; i < APP_COUNTER_COUNT; i++)
        kd_profile_counter(t->profile, t->counters[i], values[i]);
}

void app_timing_frame_end(app_timing *t)
{
    kd_allocations taken = count_allocations(t);
    if (t->gpu_timing)
        app_gpu_timing_collect(t->gpu_timing, false);
    app_timing_section(t, APP_ROW_END, false);
    kd_profile_frame_end(t->profile);
    for (uint32_t i = 0; t->mode != APP_TIMING_OFF && i < kd_schedule_count(t->schedule); i++)
        kd_profile_bytes(t->profile, i, kd_schedule_bytes_moved(t->schedule, i));
    if (t->trace)
        count_all(t, taken);
}

void app_timing_finish(app_timing *t)
{
    if (t->gpu_timing && t->mode == APP_TIMING_STAMPS)
        app_gpu_timing_collect(t->gpu_timing, true);
    for (uint32_t i = 0; i < kd_schedule_count(t->schedule); i++) {
        kd_system_statistics s = kd_schedule_statistics(t->schedule, i);
        kd_profile_count(t->profile, i,
                         &(kd_profile_counts){s.runs, s.disabled, s.not_due, s.refused, s.rows});
    }
}

void app_timing_close(app_timing *t)
{
    app_gpu_timing_destroy(t->gpu_timing);
    kd_profile_destroy(t->profile);
    *t = (app_timing){0};
}
