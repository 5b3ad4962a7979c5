/* Making a schedule, registering systems, init and fini. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/ecs/schedule_internal.h"

const char *kd_phase_name(kd_phase phase)
{
    static const char *const names[] = {
#define PHASE_NAME(name, text) text,
        KD_PHASE_LIST(PHASE_NAME)
#undef PHASE_NAME
    };
    return (unsigned)phase < KD_PHASE_COUNT ? names[phase] : "unknown";
}

/* ---- making and registering ---- */

kd_schedule *kd_schedule_make(kd_world *w, kd_jobs *jobs, struct kd_gpu *gpu)
{
    kd_schedule *s = calloc(1, sizeof *s);
    if (!s) {
        kd_fail(KD_NO_MEMORY, "schedule: no memory to make one");
        return NULL;
    }
    s->world = w;
    s->gpu = gpu;
    s->own_jobs = jobs ? NULL : kd_jobs_make(1);
    s->jobs = jobs ? jobs : s->own_jobs;
    s->systems = calloc(SCHEDULE_MAX_SYSTEMS, sizeof *s->systems);
    s->resources = calloc((size_t)SCHEDULE_MAX_SYSTEMS * KD_MAX_RESOURCE_USES, sizeof *s->resources);
    s->clock = kd_singleton(w, kd_schedule_clock);
    if (s->jobs && s->systems && s->resources && s->clock)
        return s;
    kd_fail(KD_NO_MEMORY, "schedule: no memory to make one");
    kd_schedule_destroy(s);
    return NULL;
}

static uint16_t ensure_resource(kd_schedule *s, const char *name)
{
    for (uint32_t i = 0; i < s->resource_count; i++)
        if (strcmp(s->resources[i].name, name) == 0)
            return (uint16_t)i;
    s->resources[s->resource_count].name = name;
    return (uint16_t)s->resource_count++;
}

kd_status kd_schedule_add(kd_schedule *s, const kd_system_desc *desc)
{
    assert(!s->built && desc->name && desc->run && (unsigned)desc->phase < KD_PHASE_COUNT);
    assert(!desc->rate.offset_frames || desc->rate.offset_frames < desc->rate.every_frames);
    if (s->system_count == SCHEDULE_MAX_SYSTEMS)
        return kd_fail(KD_OUT_OF_RANGE, "system %s: there are %d systems already, the most there can be",
                       desc->name, SCHEDULE_MAX_SYSTEMS);
    /* So that no component gets its id while systems run side by side. */
    for (uint32_t i = 0; i < KD_MAX_COMPONENT_USES && desc->components[i].desc; i++)
        if (!kd_component_ensure(s->world, desc->components[i].desc))
            return KD_NO_MEMORY;
    char *name = strdup(desc->name);
    if (!name)
        return kd_fail(KD_NO_MEMORY, "system %s: out of memory", desc->name);
    schedule_system *system = &s->systems[s->system_count++];
    *system = (schedule_system){.desc = *desc, .enabled = true};
    system->desc.name = name;
    system->watch = (ecs_watch){.system = name, .uses = system->desc.components};
    for (uint32_t i = 0; i < KD_MAX_RESOURCE_USES && desc->resources[i].resource; i++)
        system->resources[i] = ensure_resource(s, desc->resources[i].resource);
    return KD_OK;
}

uint32_t kd_schedule_count(const kd_schedule *s)
{
    return s->system_count;
}

const kd_system_desc *kd_schedule_system(const kd_schedule *s, uint32_t index)
{
    assert(index < s->system_count);
    return &s->systems[index].desc;
}

kd_status kd_schedule_enable(kd_schedule *s, const char *name, bool enabled)
{
    for (uint32_t i = 0; i < s->system_count; i++)
        if (strcmp(s->systems[i].desc.name, name) == 0) {
            s->systems[i].enabled = enabled;
            return KD_OK;
        }
    return kd_fail(KD_NOT_FOUND, "system %s: there is none of that name", name);
}

void kd_schedule_leave_out_gpu(kd_schedule *s)
{
    assert(!s->init_done);
    s->without_gpu = true;
}

void kd_schedule_set_hooks(kd_schedule *s, const kd_schedule_hooks *hooks)
{
    s->hooks = hooks ? *hooks : (kd_schedule_hooks){0};
}

void kd_schedule_randomize(kd_schedule *s, uint64_t seed)
{
    s->seed = seed;
}

/* ---- init and fini ---- */

kd_status kd_schedule_init(kd_schedule *s)
{
    for (uint32_t i = 0; i < s->system_count; i++) {
        schedule_system *system = &s->systems[i];
        if (system->initialized || schedule_is_left_out(s, system))
            continue;
        kd_system_context context = schedule_context(s, system, KD_GPU_LANE);
        kd_status status = system->desc.init ? system->desc.init(&context) : KD_OK;
        if (status != KD_OK)
            return status;
        system->initialized = true;
        /* It may have dispatched: the first frame must see that. */
        if (system->desc.init && system->desc.where == KD_ON_GPU)
            schedule_barrier(s, system, s->resources);
    }
    s->init_done = true;
    return kd_world_merge(s->world);
}

static void free_system(schedule_system *system)
{
    free((char *)(uintptr_t)system->desc.name);
    free(system->samples_ns);
}

void kd_schedule_destroy(kd_schedule *s)
{
    if (!s)
        return;
    for (uint32_t i = s->system_count; i-- > 0;) {
        schedule_system *system = &s->systems[i];
        kd_system_context context = schedule_context(s, system, KD_GPU_LANE);
        if (system->initialized && system->desc.fini)
            system->desc.fini(&context);
    }
    for (uint32_t i = 0; i < s->system_count; i++)
        free_system(&s->systems[i]);
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++)
        kd_arena_fini(&s->scratch[i]);
    schedule_check_destroy(s->check);
    kd_jobs_destroy(s->own_jobs);
    free(s->systems);
    free(s->resources);
    free(s->nodes);
    free(s->roots);
    free(s);
}
