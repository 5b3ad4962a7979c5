#include "runtime/app/gpu_timing.h"

#include <stdlib.h>

#include "runtime/core/clock.h"

enum {
    MAX_SPANS = 768,
    SYSTEM_SLOTS = 512, /* of a frame's slots kept for systems; passes use the others */
    NAME_CACHE = 1024,
    NO_PASS = 0,
};

/* A system or a pass of one, between two slots. */
typedef struct span {
    bool is_pass;
    uint32_t id; /* system, or name of the pass */
    uint32_t from, to;
} span;

/* A frame whose timestamps are under way. */
typedef struct frame_spans {
    uint64_t number;
    uint32_t count, slots;
    span spans[MAX_SPANS];
} frame_spans;

struct app_gpu_timing {
    kd_gpu *gpu;
    kd_profile *profile;
    uint32_t frame_row, idle_row;
    bool sync, passes;
    uint64_t next_frame; /* whose timestamps are wanted next */
    frame_spans frames[KD_GPU_TIMER_FRAMES];
    /* what is open: a system, and within it a pass by its program */
    bool in_system;
    uint32_t pass_program, pass_name, system_slot, pass_slot;
    uint64_t system_ns, pass_ns;
    /* the frame in sync mode */
    uint64_t first_ns, last_ns, busy_ns;
    struct {
        uint32_t program, name;
    } names[NAME_CACHE];
};

/* ---- slots ---- */

static frame_spans *current(app_gpu_timing *g)
{
    uint64_t number = kd_gpu_frame(g->gpu);
    frame_spans *frame = &g->frames[number % KD_GPU_TIMER_FRAMES];
    if (frame->number != number)
        *frame = (frame_spans){.number = number};
    return frame;
}

static uint32_t stamp(app_gpu_timing *g)
{
    frame_spans *frame = current(g);
    uint32_t slot = frame->slots < KD_GPU_TIMER_SLOTS ? frame->slots++ : KD_GPU_TIMER_SLOTS - 1;
    kd_gpu_timestamp(g->gpu, slot);
    return slot;
}

static void add_span(app_gpu_timing *g, bool is_pass, uint32_t id, uint32_t from, uint32_t to)
{
    frame_spans *frame = current(g);
    if (frame->count < MAX_SPANS)
        frame->spans[frame->count++] = (span){is_pass, id, from, to};
}

/* ---- passes ---- */

static uint32_t name_of(app_gpu_timing *g, uint32_t program, const char *text)
{
    uint32_t at = program % NAME_CACHE;
    if (g->names[at].program != program || !g->names[at].name) {
        g->names[at].program = program;
        g->names[at].name = kd_profile_pass_name(g->profile, text);
    }
    return g->names[at].name;
}

static void close_pass(app_gpu_timing *g, uint32_t slot, uint64_t now_ns)
{
    if (g->pass_program == NO_PASS)
        return;
    if (g->sync)
        kd_profile_gpu_pass(g->profile, g->pass_name, g->pass_ns, now_ns);
    else
        add_span(g, true, g->pass_name, g->pass_slot, slot);
    g->pass_program = NO_PASS;
}

/* Before a dispatch or draw: another program than the last one's is another pass. */
static void on_pass(void *user, uint32_t program, const char *name)
{
    app_gpu_timing *g = user;
    if (!g->in_system || program == g->pass_program)
        return;
    if (!g->sync && current(g)->slots >= KD_GPU_TIMER_SLOTS - SYSTEM_SLOTS)
        return;
    bool first = g->pass_program == NO_PASS;
    if (g->sync && !first)
        kd_gpu_finish(g->gpu);
    uint64_t now_ns = g->sync ? kd_clock_ns() : 0;
    uint32_t slot = g->sync ? 0 : first ? g->system_slot : stamp(g);
    close_pass(g, slot, now_ns);
    g->pass_program = program;
    g->pass_name = name_of(g, program, name);
    g->pass_slot = slot;
    g->pass_ns = now_ns;
}

/* Between two systems of a frame the GPU waits for the CPU. */
static void add_idle(app_gpu_timing *g, uint64_t from_ns, uint64_t to_ns)
{
    if (from_ns && to_ns > from_ns)
        kd_profile_gpu_zone(g->profile, g->idle_row, from_ns, to_ns);
}

/* ---- systems ---- */

app_gpu_timing *app_gpu_timing_make(kd_gpu *gpu, kd_profile *profile, uint32_t frame_row, uint32_t idle_row,
                                    bool sync, bool passes)
{
    app_gpu_timing *g = calloc(1, sizeof *g);
    if (!g)
        return NULL;
    g->gpu = gpu;
    g->profile = profile;
    g->frame_row = frame_row;
    g->idle_row = idle_row;
    g->sync = sync;
    g->passes = passes;
    g->next_frame = kd_gpu_frame(gpu);
    for (uint32_t i = 0; i < KD_GPU_TIMER_FRAMES; i++)
        g->frames[i].number = UINT64_MAX;
    if (passes)
        kd_gpu_set_pass_hook(gpu, on_pass, g);
    return g;
}

void app_gpu_timing_destroy(app_gpu_timing *g)
{
    if (g && g->passes)
        kd_gpu_set_pass_hook(g->gpu, NULL, NULL);
    free(g);
}

void app_gpu_timing_begin(app_gpu_timing *g, uint32_t system)
{
    (void)system;
    if (g->sync) {
        kd_gpu_finish(g->gpu);
        g->system_ns = kd_clock_ns();
    } else {
        g->system_slot = stamp(g);
    }
    g->in_system = true;
}

void app_gpu_timing_end(app_gpu_timing *g, uint32_t system)
{
    g->in_system = false;
    if (!g->sync) {
        uint32_t slot = stamp(g);
        close_pass(g, slot, 0);
        add_span(g, false, system, g->system_slot, slot);
        return;
    }
    kd_gpu_finish(g->gpu);
    uint64_t now_ns = kd_clock_ns();
    close_pass(g, 0, now_ns);
    kd_profile_gpu_zone(g->profile, system, g->system_ns, now_ns);
    add_idle(g, g->last_ns, g->system_ns);
    g->first_ns = g->first_ns ? g->first_ns : g->system_ns;
    g->last_ns = now_ns;
    g->busy_ns += now_ns - g->system_ns;
}

/* ---- frames ---- */

static void end_frame(app_gpu_timing *g, uint64_t first_ns, uint64_t last_ns, uint64_t busy_ns)
{
    if (!first_ns || last_ns < first_ns)
        return;
    uint64_t whole_ns = last_ns - first_ns;
    kd_profile_gpu_zone(g->profile, g->frame_row, first_ns, last_ns);
    kd_profile_gpu(g->profile, g->frame_row, whole_ns);
    kd_profile_gpu(g->profile, g->idle_row, whole_ns > busy_ns ? whole_ns - busy_ns : 0);
}

static void feed(app_gpu_timing *g, const frame_spans *frame, const uint64_t *ns)
{
    uint64_t first_ns = 0, last_ns = 0, busy_ns = 0;
    for (uint32_t i = 0; i < frame->count; i++) {
        const span *s = &frame->spans[i];
        uint64_t from = ns[s->from], to = ns[s->to];
        if (!from || to < from)
            continue;
        if (s->is_pass) {
            kd_profile_gpu_pass(g->profile, s->id, from, to);
            continue;
        }
        kd_profile_gpu(g->profile, s->id, to - from);
        kd_profile_gpu_zone(g->profile, s->id, from, to);
        add_idle(g, last_ns, from);
        first_ns = first_ns && first_ns < from ? first_ns : from;
        last_ns = to > last_ns ? to : last_ns;
        busy_ns += to - from;
    }
    end_frame(g, first_ns, last_ns, busy_ns);
}

static void collect_stamps(app_gpu_timing *g)
{
    uint64_t ns[KD_GPU_TIMER_SLOTS], now = kd_gpu_frame(g->gpu);
    if (now > g->next_frame + KD_GPU_TIMER_FRAMES - 1) /* its ring entry has been written over */
        g->next_frame = now - KD_GPU_TIMER_FRAMES + 1;
    for (; g->next_frame < now; g->next_frame++) {
        const frame_spans *frame = &g->frames[g->next_frame % KD_GPU_TIMER_FRAMES];
        if (frame->number != g->next_frame)
            continue; /* nothing ran on the GPU */
        if (!kd_gpu_read_frame_timestamps(g->gpu, g->next_frame, ns, frame->slots))
            return;
        feed(g, frame, ns);
    }
}

void app_gpu_timing_collect(app_gpu_timing *g, bool all)
{
    if (g->sync) {
        end_frame(g, g->first_ns, g->last_ns, g->busy_ns);
        g->first_ns = g->last_ns = g->busy_ns = 0;
        return;
    }
    if (all)
        kd_gpu_finish(g->gpu);
    collect_stamps(g);
}
