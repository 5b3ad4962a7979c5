/* Registering systems and running frames. */
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
    if (s->jobs && s->systems && s->resources)
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

static bool is_left_out(const kd_schedule *s, const schedule_system *system)
{
    return s->without_gpu && system->desc.where == KD_ON_GPU;
}

void kd_schedule_set_hooks(kd_schedule *s, const kd_schedule_hooks *hooks)
{
    s->hooks = hooks ? *hooks : (kd_schedule_hooks){0};
}

void kd_schedule_randomize(kd_schedule *s, uint64_t seed)
{
    s->seed = seed;
}

/* ---- calling a system ---- */

static kd_system_context make_context(kd_schedule *s, const schedule_system *system, uint32_t worker)
{
    const kd_system_desc *desc = &system->desc;
    return (kd_system_context){
        .world = s->world,
        .gpu = desc->where == KD_ON_GPU ? s->gpu : NULL,
        .jobs = s->jobs,
        .scratch = &s->scratch[worker],
        .commands = desc->no_commands ? NULL : kd_world_commands(s->world, worker),
        .user = desc->user,
        .worker = worker,
        .command_key = system->command_key,
    };
}

uint64_t kd_schedule_bytes_moved(kd_schedule *s, uint32_t index)
{
    assert(index < s->system_count);
    kd_system_context context = make_context(s, &s->systems[index], KD_GPU_LANE);
    uint64_t (*bytes_moved)(const kd_system_context *) = s->systems[index].desc.bytes_moved;
    return bytes_moved ? bytes_moved(&context) : 0;
}

static void set_key(kd_schedule *s, uint32_t worker, uint64_t key)
{
    s->keys[worker] = key;
    kd_commands_key(kd_world_commands(s->world, worker), key);
}

static void run_system(kd_schedule *s, uint32_t index, uint32_t worker)
{
    schedule_system *system = &s->systems[index];
    kd_system_context context = make_context(s, system, worker);
    if (!system->enabled || is_left_out(s, system) || (system->desc.run_if && !system->desc.run_if(&context)))
        return;
    uint64_t outer_key = s->keys[worker]; /* a system that waits for its jobs may be helping with this one */
    set_key(s, worker, system->command_key);
    if (s->hooks.begin)
        s->hooks.begin(s->hooks.user, index, worker);
    if (system->desc.where == KD_ON_GPU) {
        uint32_t uses = schedule_barrier(s, system, s->resources);
        if (uses && s->hooks.barrier)
            s->hooks.barrier(s->hooks.user, s->gpu, uses);
    }
    system->desc.run(&context);
    if (s->hooks.end)
        s->hooks.end(s->hooks.user, index, worker);
    set_key(s, worker, outer_key);
}

static void merge(kd_schedule *s)
{
    kd_status status = kd_world_merge(s->world);
    int none = KD_OK;
    atomic_compare_exchange_strong(&s->status, &none, (int)status);
}

/* ---- init and fini ---- */

kd_status kd_schedule_init(kd_schedule *s)
{
    for (uint32_t i = 0; i < s->system_count; i++) {
        schedule_system *system = &s->systems[i];
        if (system->initialized || is_left_out(s, system))
            continue;
        kd_system_context context = make_context(s, system, KD_GPU_LANE);
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

void kd_schedule_destroy(kd_schedule *s)
{
    if (!s)
        return;
    for (uint32_t i = s->system_count; i-- > 0;) {
        schedule_system *system = &s->systems[i];
        kd_system_context context = make_context(s, system, KD_GPU_LANE);
        if (system->initialized && system->desc.fini)
            system->desc.fini(&context);
    }
    for (uint32_t i = 0; i < s->system_count; i++)
        free((char *)(uintptr_t)s->systems[i].desc.name);
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++)
        kd_arena_fini(&s->scratch[i]);
    kd_jobs_destroy(s->own_jobs);
    free(s->systems);
    free(s->resources);
    free(s->nodes);
    free(s);
}

/* ---- one frame ---- */

static void node_job(void *user, uint32_t worker);

static void finish_node(kd_schedule *s, const schedule_node *node)
{
    for (uint32_t w = 0; w < SCHEDULE_SET_WORDS; w++)
        for (uint64_t bits = node->after.words[w]; bits; bits &= bits - 1) {
            schedule_node *next = &s->nodes[w * 64 + (uint32_t)__builtin_ctzll(bits)];
            if (schedule_on_lane(s, next))
                kd_jobs_lower(s->jobs, &next->blocked, 1);
            else if (atomic_fetch_sub(&next->blocked.pending, 1) == 1)
                kd_jobs_run(s->jobs, node_job, next, NULL);
        }
}

static void node_job(void *user, uint32_t worker)
{
    schedule_node *node = user;
    kd_schedule *s = node->schedule;
    run_system(s, node->system, worker);
    finish_node(s, node);
    kd_jobs_lower(s->jobs, &s->unfinished, 1);
}

static void run_lane_node(kd_schedule *s, const schedule_node *node)
{
    if (node->system == SCHEDULE_MERGE)
        merge(s);
    else
        run_system(s, node->system, KD_GPU_LANE);
}

static void run_graph(kd_schedule *s)
{
    for (uint32_t i = 0; i < s->node_count; i++)
        atomic_store_explicit(&s->nodes[i].blocked.pending, s->nodes[i].before_count, memory_order_relaxed);
    atomic_store_explicit(&s->unfinished.pending, s->job_count, memory_order_relaxed);
    for (uint32_t i = 0; i < s->node_count; i++)
        if (s->nodes[i].before_count == 0 && !schedule_on_lane(s, &s->nodes[i]))
            kd_jobs_run(s->jobs, node_job, &s->nodes[i], NULL);
    for (uint32_t i = 0; i < s->node_count; i++) {
        schedule_node *node = &s->nodes[i];
        if (!schedule_on_lane(s, node))
            continue;
        kd_jobs_wait(s->jobs, &node->blocked);
        run_lane_node(s, node);
        finish_node(s, node);
    }
    kd_jobs_wait(s->jobs, &s->unfinished);
}

/* Source: Steele, Lea, Flood 2014, SplitMix64. */
static uint64_t next_random(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

static bool is_subset(const schedule_set *a, const schedule_set *b)
{
    for (uint32_t w = 0; w < SCHEDULE_SET_WORDS; w++)
        if (a->words[w] & ~b->words[w])
            return false;
    return true;
}

/* Run the nodes one at a time in some order that their conflicts allow. Barriers follow the order taken. */
static void run_shuffled(kd_schedule *s)
{
    uint64_t random = s->seed ^ s->frame_number * 0xD1342543DE82EF95u;
    schedule_set done = {0};
    uint32_t ready[SCHEDULE_MAX_NODES];
    for (uint32_t left = s->node_count; left > 0; left--) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < s->node_count; i++)
            if (!schedule_set_has(&done, i) && is_subset(&s->nodes[i].conflicts_before, &done))
                ready[count++] = i;
        uint32_t chosen = ready[next_random(&random) % count];
        run_lane_node(s, &s->nodes[chosen]);
        schedule_set_add(&done, chosen);
    }
}

kd_status kd_schedule_run(kd_schedule *s)
{
    assert(kd_jobs_worker(s->jobs) == KD_GPU_LANE);
    kd_status status = s->init_done ? KD_OK : kd_schedule_init(s);
    if (status == KD_OK && !s->built)
        status = schedule_build(s);
    if (status != KD_OK)
        return status;
    for (uint32_t i = 0; i < kd_jobs_threads(s->jobs); i++)
        kd_arena_reset(&s->scratch[i]);
    atomic_store(&s->status, (int)KD_OK);
    if (s->seed)
        run_shuffled(s);
    else
        run_graph(s);
    merge(s);
    s->frame_number++;
    return (kd_status)atomic_load(&s->status);
}
