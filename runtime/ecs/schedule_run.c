/* Running systems and frames. */
#include <assert.h>

#include "runtime/core/clock.h"
#include "runtime/ecs/internal.h"
#include "runtime/ecs/schedule_internal.h"

/* ---- one system ---- */

kd_system_context schedule_context(kd_schedule *s, const schedule_system *system, uint32_t worker)
{
    const kd_system_desc *desc = &system->desc;
    return (kd_system_context){
        .world = s->world,
        .gpu = desc->where == KD_ON_GPU ? s->gpu : NULL,
        .jobs = schedule_pool(s),
        .scratch = &s->scratch[worker],
        .commands = desc->no_commands ? NULL : kd_world_commands(s->world, worker),
        .user = desc->user,
        .worker = worker,
        .command_key = system->command_key,
    };
}

static void fail_frame(kd_schedule *s, kd_status status)
{
    int none = KD_OK;
    if (status != KD_OK)
        atomic_compare_exchange_strong(&s->status, &none, (int)status);
}

static void run_measured(kd_schedule *s, schedule_system *system, kd_system_context *context)
{
    if (!s->measured) {
        system->desc.run(context);
        return;
    }
    uint64_t begun = kd_clock_ns();
    system->desc.run(context);
    schedule_add_sample(system, kd_clock_ns() - begun);
}

/* Run it once, with all that belongs to it: key, hooks, barrier, check. */
static void run_once(kd_schedule *s, uint32_t index, kd_system_context *context)
{
    schedule_system *system = &s->systems[index];
    uint32_t worker = context->worker;
    kd_commands *commands = kd_world_commands(s->world, worker);
    uint64_t outer_key = commands->key; /* a system that waits for its jobs may be helping with this one */
    kd_commands_key(commands, context->command_key);
    uint32_t outer_label = kd_jobs_set_label(s->jobs, worker, index + 1);
    if (s->hooks.begin)
        s->hooks.begin(s->hooks.user, index, worker);
    if (system->desc.where == KD_ON_GPU) {
        uint32_t uses = schedule_barrier(s, system, s->resources);
        if (uses && s->hooks.barrier)
            s->hooks.barrier(s->hooks.user, s->gpu, uses);
    }
    bool checked = s->check && !system->desc.exclusive;
    if (checked)
        schedule_check_begin(s, system);
    run_measured(s, system, context);
    if (checked)
        fail_frame(s, schedule_check_end(s, system));
    if (s->hooks.end)
        s->hooks.end(s->hooks.user, index, worker);
    kd_jobs_set_label(s->jobs, worker, outer_label);
    context->command_key += (uint64_t)1 << 32; /* its next run of this frame is merged behind this one */
    kd_commands_key(commands, outer_key);
    system->counts.runs++;
}

static void run_due(kd_schedule *s, uint32_t index, uint32_t due, uint32_t worker)
{
    schedule_system *system = &s->systems[index];
    kd_system_context context = schedule_context(s, system, worker);
    uint64_t runs = system->counts.runs;
    while (due-- > 0) {
        schedule_set_time(s, system, due, &context);
        if (!system->desc.run_if || system->desc.run_if(&context))
            run_once(s, index, &context);
    }
    system->counts.refused += runs == system->counts.runs;
}

static void run_system(kd_schedule *s, uint32_t index, uint32_t worker)
{
    schedule_system *system = &s->systems[index];
    if (!system->enabled || schedule_is_left_out(s, system)) {
        system->counts.disabled++;
        return;
    }
    uint64_t dropped;
    uint32_t due = schedule_due(s, system, &dropped);
    system->counts.dropped += dropped;
    if (!due) {
        system->counts.not_due++;
        return;
    }
    ecs_watch *outer = ecs_watching;
    schedule_watch(s, system);
    ecs_watching = &system->watch;
    run_due(s, index, due, worker);
    ecs_watching = outer;
    fail_frame(s, system->watch.status);
}

/* ---- all at once ---- */

static void node_job(void *user, uint32_t worker);

/* The node has ended: let those go that waited for it alone. Returns one to go on with here, if `goes_on`. */
static schedule_node *finish_node(kd_schedule *s, const schedule_node *node, bool goes_on)
{
    schedule_node *chosen = NULL;
    for (uint32_t w = 0; w < SCHEDULE_SET_WORDS; w++)
        for (uint64_t bits = node->after.words[w]; bits; bits &= bits - 1) {
            schedule_node *next = &s->nodes[w * 64 + (uint32_t)__builtin_ctzll(bits)];
            if (schedule_on_lane(s, next))
                kd_jobs_lower(s->jobs, &next->blocked, 1);
            else if (atomic_fetch_sub(&next->blocked.pending, 1) != 1)
                continue;
            else if (goes_on && !chosen)
                chosen = next;
            else
                kd_jobs_run(s->jobs, node_job, next, &s->unfinished);
        }
    return chosen;
}

static void node_job(void *user, uint32_t worker)
{
    schedule_node *node = user;
    kd_schedule *s = node->schedule;
    for (; node; node = finish_node(s, node, true))
        run_system(s, node->system, worker);
}

/* Tell whoever watches what the lane spends on the schedule itself. */
static void tell_own(const kd_schedule *s, bool is_merge, bool begin)
{
    if (s->hooks.own)
        s->hooks.own(s->hooks.user, is_merge, begin);
}

static void wait_for(kd_schedule *s, kd_job_counter *counter)
{
    if (!atomic_load(&counter->pending))
        return;
    tell_own(s, false, true);
    kd_jobs_wait(s->jobs, counter);
    tell_own(s, false, false);
}

static void merge(kd_schedule *s)
{
    tell_own(s, true, true);
    fail_frame(s, kd_world_merge(s->world));
    tell_own(s, true, false);
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
    if (s->root_count)
        kd_jobs_run_n(s->jobs, node_job, s->roots, s->root_count, &s->unfinished);
    for (uint32_t i = 0; i < s->node_count; i++) {
        schedule_node *node = &s->nodes[i];
        if (!schedule_on_lane(s, node))
            continue;
        wait_for(s, &node->blocked);
        run_lane_node(s, node);
        finish_node(s, node, false);
    }
    wait_for(s, &s->unfinished);
}

/* ---- one by one ---- */

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

/* Run the nodes one at a time: in their order, or with a seed in some order that their conflicts allow.
 * Barriers follow the order taken. */
static void run_serially(kd_schedule *s)
{
    uint64_t random = s->seed ^ s->clock->frame * 0xD1342543DE82EF95u;
    schedule_set done = {0};
    uint32_t ready[SCHEDULE_MAX_NODES];
    for (uint32_t left = s->node_count; left > 0 && atomic_load(&s->status) != KD_USAGE; left--) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < s->node_count; i++)
            if (!schedule_set_has(&done, i) && is_subset(&s->nodes[i].conflicts_before, &done))
                ready[count++] = i;
        uint32_t chosen = ready[s->seed ? next_random(&random) % count : 0];
        run_lane_node(s, &s->nodes[chosen]);
        schedule_set_add(&done, chosen);
    }
}

/* ---- a frame ---- */

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
    if (s->seed || s->check)
        run_serially(s);
    else
        run_graph(s);
    merge(s);
    schedule_clock_advance(s);
    return (kd_status)atomic_load(&s->status);
}
