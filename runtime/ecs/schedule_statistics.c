/* What each system did, and how long it took. */
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/ecs/schedule_internal.h"

kd_status kd_schedule_measure(kd_schedule *s, bool measured)
{
    for (uint32_t i = 0; i < s->system_count && measured; i++) {
        schedule_system *system = &s->systems[i];
        if (!system->samples_ns)
            system->samples_ns = malloc(SCHEDULE_SAMPLES * sizeof *system->samples_ns);
        if (!system->samples_ns)
            return kd_fail(KD_NO_MEMORY, "system %s: out of memory for its times", system->desc.name);
    }
    s->measured = measured;
    return KD_OK;
}

void schedule_add_sample(schedule_system *system, uint64_t ns)
{
    double ms = (double)ns * 1e-6;
    if (!system->samples_ns)
        return; /* registered after measuring began */
    system->samples_ns[system->sample_count++ % SCHEDULE_SAMPLES] =
        ns < UINT32_MAX ? (uint32_t)ns : UINT32_MAX;
    system->counts.total_ms += ms;
    if (ms > system->counts.max_ms)
        system->counts.max_ms = ms;
}

static int compare_ns(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Of an even number: between the two in the middle. */
static double median_ms(const schedule_system *system)
{
    uint32_t sorted[SCHEDULE_SAMPLES];
    size_t count = system->sample_count < SCHEDULE_SAMPLES ? system->sample_count : SCHEDULE_SAMPLES;
    if (!count)
        return 0;
    memcpy(sorted, system->samples_ns, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_ns);
    return ((double)sorted[(count - 1) / 2] + (double)sorted[count / 2]) * 0.5e-6;
}

kd_system_statistics kd_schedule_statistics(const kd_schedule *s, uint32_t index)
{
    if (index >= s->system_count)
        return (kd_system_statistics){0};
    const schedule_system *system = &s->systems[index];
    kd_system_statistics counts = system->counts;
    counts.median_ms = median_ms(system);
    counts.rows = system->watch.rows;
    counts.tables = system->watch.tables;
    return counts;
}

uint64_t kd_schedule_bytes_moved(kd_schedule *s, uint32_t index)
{
    if (index >= s->system_count)
        return 0;
    kd_system_context context = schedule_context(s, &s->systems[index], KD_GPU_LANE);
    uint64_t (*bytes_moved)(const kd_system_context *) = s->systems[index].desc.bytes_moved;
    return bytes_moved ? bytes_moved(&context) : 0;
}
