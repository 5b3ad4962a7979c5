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

/* What is wrong with a description, and what to do; NULL: nothing. */
static const char *find_mistake(const kd_schedule *s, const kd_system_desc *desc)
{
    const kd_system_rate *rate = &desc->rate;
    if (s->built)
        return "a frame has run already; add all systems before the first";
    if (!desc->name)
        return "it has no name; give it one";
    if (!desc->run)
        return "it has no function to run; set .run";
    if ((unsigned)desc->phase >= KD_PHASE_COUNT)
        return "its phase is unknown; take one of kd_phase";
    if (!(rate->every_s >= 0) || (rate->every_s > 0 && rate->every_frames))
        return "its rate is negative, or by time and by frames; set one of .every_s and .every_frames";
    if (rate->offset_frames && rate->offset_frames >= rate->every_frames)
        return "its rate's offset is not less than .every_frames; lower it";
    return NULL;
}

kd_status kd_schedule_add(kd_schedule *s, const kd_system_desc *desc)
{
    const char *mistake = find_mistake(s, desc);
    if (mistake)
        return kd_fail(KD_USAGE, "system %s: %s", desc->name ? desc->name : "without a name", mistake);
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
    return index < s->system_count ? &s->systems[index].desc : NULL;
}

kd_status kd_schedule_enable(kd_schedule *s, const char *name, bool enabled)
{
    bool found = false;
    for (uint32_t i = 0; i < s->system_count; i++)
        if (strcmp(s->systems[i].desc.name, name) == 0) {
            s->systems[i].enabled = enabled;
            found = true;
        }
    return found ? KD_OK : kd_fail(KD_NOT_FOUND, "system %s: there is none of that name", name);
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
