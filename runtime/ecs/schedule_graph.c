/* Derivation of the frame's graph and of the memory barriers from what the systems declare. */
#include <stdlib.h>

#include "runtime/core/log.h"
#include "runtime/ecs/schedule_internal.h"

/* ---- conflicts ---- */

static bool components_conflict(const kd_system_desc *a, const kd_system_desc *b)
{
    for (const kd_component_use *u = a->components; u < a->components + KD_MAX_COMPONENT_USES && u->desc; u++)
        for (const kd_component_use *v = b->components; v < b->components + KD_MAX_COMPONENT_USES && v->desc;
             v++)
            if ((u->write || v->write) && ecs_same_component(u->desc, v->desc))
                return true;
    return false;
}

static bool resources_conflict(const schedule_system *a, const schedule_system *b)
{
    for (uint32_t i = 0; i < KD_MAX_RESOURCE_USES && a->desc.resources[i].resource; i++)
        for (uint32_t k = 0; k < KD_MAX_RESOURCE_USES && b->desc.resources[k].resource; k++)
            if (a->resources[i] == b->resources[k] &&
                (a->desc.resources[i].use | b->desc.resources[k].use) & KD_USE_WRITES)
                return true;
    return false;
}

static bool conflict(const schedule_system *a, const schedule_system *b)
{
    return a->desc.exclusive || b->desc.exclusive || components_conflict(&a->desc, &b->desc) ||
           resources_conflict(a, b);
}

static bool may_record(const kd_system_desc *desc)
{
    bool writes = desc->exclusive;
    for (uint32_t i = 0; i < KD_MAX_COMPONENT_USES && desc->components[i].desc; i++)
        writes |= desc->components[i].write;
    return writes && !desc->no_commands;
}

/* ---- nodes ---- */

static void add_node(kd_schedule *s, uint32_t system, kd_phase phase)
{
    schedule_node *node = &s->nodes[s->node_count++];
    *node = (schedule_node){.schedule = s, .system = system, .phase = phase};
    if (system != SCHEDULE_MERGE)
        s->systems[system].command_key = (uint64_t)s->node_count << SCHEDULE_KEY_SHIFT;
}

static void add_phase(kd_schedule *s, kd_phase phase)
{
    bool records = false;
    for (uint32_t i = 0; i < s->system_count; i++)
        if (s->systems[i].desc.phase == phase) {
            add_node(s, i, phase);
            records |= may_record(&s->systems[i].desc);
        }
    if (records)
        add_node(s, SCHEDULE_MERGE, phase);
}

static bool must_precede(const kd_schedule *s, const schedule_node *first, const schedule_node *second,
                         bool lane)
{
    if (first->system == SCHEDULE_MERGE || second->system == SCHEDULE_MERGE)
        return true;
    if (lane && schedule_on_lane(s, first) && schedule_on_lane(s, second))
        return true;
    return conflict(&s->systems[first->system], &s->systems[second->system]);
}

/* Add the edges that end in node `to`, nearest predecessor first; one that is reached already through a
 * nearer one is left out. reach[i] holds all nodes from which i can be reached. */
static void add_edges(kd_schedule *s, uint32_t to, bool lane, schedule_set *reach, schedule_set *before)
{
    reach[to] = (schedule_set){0};
    for (uint32_t from = to; from-- > 0;) {
        if (schedule_set_has(&reach[to], from) || !must_precede(s, &s->nodes[from], &s->nodes[to], lane))
            continue;
        schedule_set_add(before, from);
        schedule_set_add(&reach[to], from);
        for (uint32_t w = 0; w < SCHEDULE_SET_WORDS; w++)
            reach[to].words[w] |= reach[from].words[w];
    }
}

kd_status schedule_build(kd_schedule *s)
{
    schedule_set *reach = malloc(2 * SCHEDULE_MAX_NODES * sizeof *reach);
    s->nodes = calloc(SCHEDULE_MAX_NODES, sizeof *s->nodes);
    s->roots = calloc(SCHEDULE_MAX_NODES, sizeof *s->roots);
    if (!reach || !s->nodes || !s->roots) {
        free(reach);
        free(s->nodes);
        free(s->roots);
        s->nodes = NULL;
        s->roots = NULL;
        return kd_fail(KD_NO_MEMORY, "schedule: no memory for the frame's graph");
    }
    for (int phase = 0; phase < KD_PHASE_COUNT; phase++)
        add_phase(s, (kd_phase)phase);
    for (uint32_t to = 0; to < s->node_count; to++) {
        schedule_node *node = &s->nodes[to];
        add_edges(s, to, true, reach, &node->before);
        add_edges(s, to, false, reach + SCHEDULE_MAX_NODES, &node->conflicts_before);
        for (uint32_t from = 0; from < to; from++)
            if (schedule_set_has(&node->before, from)) {
                schedule_set_add(&s->nodes[from].after, to);
                node->before_count++;
            }
        if (node->before_count == 0 && !schedule_on_lane(s, node))
            s->roots[s->root_count++] = node;
    }
    free(reach);
    s->built = true;
    return KD_OK;
}

/* ---- barriers ----
 *
 * Source: OpenGL 4.5 core, 7.12.2. What shaders write through storage blocks and images is seen by a later
 * use only behind a barrier with the bit of that use; one barrier serves all earlier writes of all resources.
 * A shader write may also overtake earlier reads of the same memory unless a barrier with the bit of the
 * write lies between. Other writes (rendering, copies) keep their order with everything by themselves. */

#define SHADER_WRITES (KD_USE_STORAGE_WRITE | KD_USE_IMAGE_WRITE)
#define READS         (SCHEDULE_ALL_USES & ~(uint32_t)KD_USE_WRITES)

/* Widen to all uses that the barrier for these serves as well. */
static uint32_t served(uint32_t uses)
{
    static const uint32_t groups[] = {KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE,
                                      KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE,
                                      KD_USE_COPY_READ | KD_USE_COPY_WRITE};
    for (int i = 0; i < 3; i++)
        if (uses & groups[i])
            uses |= groups[i];
    return uses;
}

uint32_t schedule_barrier(const kd_schedule *s, const schedule_system *system, schedule_resource *resources)
{
    const kd_resource_use *uses = system->desc.resources;
    uint32_t needed = 0;
    for (uint32_t i = 0; i < KD_MAX_RESOURCE_USES && uses[i].resource; i++) {
        const schedule_resource *r = &resources[system->resources[i]];
        needed |= uses[i].use & (r->stale | r->unordered);
    }
    if (needed)
        for (uint32_t i = 0; i < s->resource_count; i++) {
            resources[i].stale &= ~served(needed);
            resources[i].unordered &= ~served(needed);
        }
    for (uint32_t i = 0; i < KD_MAX_RESOURCE_USES && uses[i].resource; i++) {
        schedule_resource *r = &resources[system->resources[i]];
        if (uses[i].use & SHADER_WRITES)
            r->stale = SCHEDULE_ALL_USES;
        if (uses[i].use & READS)
            r->unordered |= SHADER_WRITES;
    }
    return needed;
}
