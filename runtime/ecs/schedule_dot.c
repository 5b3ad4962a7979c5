/* The frame's graph for Graphviz: phases as clusters, GPU systems as boxes that carry the barrier before
 * them. A system that is switched off has a dashed border. */
#include <stdlib.h>

#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/ecs/schedule_internal.h"

static const char *const use_names[] = {"storage_read", "storage_write", "image_read", "image_write",
                                        "sampled",      "vertex",        "index",      "indirect",
                                        "uniform",      "target",        "copy_read",  "copy_write"};

static void write_uses(FILE *out, uint32_t uses)
{
    const char *between = "";
    for (uint32_t i = 0; i < sizeof use_names / sizeof use_names[0]; i++)
        if (uses >> i & 1) {
            fprintf(out, "%s%s", between, use_names[i]);
            between = " ";
        }
}

/* Names come from programs, not from files, but a quote would still break the file. */
static void write_name(FILE *out, const char *name)
{
    for (; *name; name++) {
        if (*name == '"' || *name == '\\')
            fputc('\\', out);
        fputc(*name, out);
    }
}

/* When it runs, if that is not once in every frame. */
static void write_rate(FILE *out, const kd_system_desc *desc)
{
    const kd_system_rate *rate = &desc->rate;
    if (rate->every_s > 0)
        fprintf(out, "\\nevery %g s", rate->every_s);
    else if (rate->every_frames > 1)
        fprintf(out, "\\nevery %u frames from %u on", (unsigned)rate->every_frames,
                (unsigned)rate->offset_frames);
    if (desc->run_if)
        fputs("\\nif its condition holds", out);
}

static void write_node(FILE *out, const kd_schedule *s, uint32_t index, uint32_t barrier)
{
    const schedule_node *node = &s->nodes[index];
    if (node->system == SCHEDULE_MERGE) {
        fprintf(out, "    n%u [label=\"merge\", shape=diamond, style=solid];\n", (unsigned)index);
        return;
    }
    const schedule_system *system = &s->systems[node->system];
    const kd_system_desc *desc = &system->desc;
    fprintf(out, "    n%u [label=\"", (unsigned)index);
    write_name(out, desc->name);
    write_rate(out, desc);
    if (barrier) {
        fputs("\\nbarrier: ", out);
        write_uses(out, barrier);
    }
    fprintf(out, "\", %s%s];\n",
            desc->where == KD_ON_GPU ? "shape=box, fillcolor=\"#dce8f8\""
                                     : "shape=ellipse, fillcolor=\"#f8f0dc\"",
            system->enabled && !schedule_is_left_out(s, system) ? "" : ", style=\"filled,dashed\"");
}

static void write_phase(FILE *out, const kd_schedule *s, kd_phase phase, const uint32_t *barriers)
{
    bool opened = false;
    for (uint32_t i = 0; i < s->node_count; i++) {
        if (s->nodes[i].phase != phase)
            continue;
        if (!opened)
            fprintf(out, "  subgraph cluster_%s {\n    label=\"%s\";\n", kd_phase_name(phase),
                    kd_phase_name(phase));
        opened = true;
        write_node(out, s, i, barriers[i]);
    }
    if (opened)
        fputs("  }\n", out);
}

/* An edge into a GPU system with a barrier carries it when the predecessor's shader writes are among its
 * reasons. */
static uint32_t edge_barrier(const kd_schedule *s, uint32_t from, uint32_t to, uint32_t barrier)
{
    if (!barrier || s->nodes[from].system == SCHEDULE_MERGE)
        return 0;
    const schedule_system *a = &s->systems[s->nodes[from].system], *b = &s->systems[s->nodes[to].system];
    uint32_t uses = 0;
    for (uint32_t i = 0; i < KD_MAX_RESOURCE_USES && a->desc.resources[i].resource; i++)
        for (uint32_t k = 0; k < KD_MAX_RESOURCE_USES && b->desc.resources[k].resource; k++)
            if (a->resources[i] == b->resources[k] &&
                a->desc.resources[i].use & (KD_USE_STORAGE_WRITE | KD_USE_IMAGE_WRITE))
                uses |= b->desc.resources[k].use & barrier;
    return uses;
}

static void write_edges(FILE *out, const kd_schedule *s, const uint32_t *barriers)
{
    for (uint32_t to = 0; to < s->node_count; to++)
        for (uint32_t from = 0; from < to; from++) {
            if (!schedule_set_has(&s->nodes[to].before, from))
                continue;
            uint32_t uses = edge_barrier(s, from, to, barriers[to]);
            bool order_only = !schedule_set_has(&s->nodes[to].conflicts_before, from);
            fprintf(out, "  n%u -> n%u", (unsigned)from, (unsigned)to);
            if (uses) {
                fputs(" [label=\"", out);
                write_uses(out, uses);
                fputs("\"]", out);
            } else if (order_only) {
                fputs(" [style=dotted]", out); /* nothing but the order of the lane */
            }
            fputs(";\n", out);
        }
}

/* Walk two frames in which every system runs: the second has the barriers of a steady frame. */
static kd_status find_barriers(const kd_schedule *s, uint32_t *barriers)
{
    schedule_resource *state = calloc(s->resource_count + 1, sizeof *state);
    if (!state)
        return kd_fail(KD_NO_MEMORY, "out of memory for the graph's barriers");
    for (int frame = 0; frame < 2; frame++)
        for (uint32_t i = 0; i < s->node_count; i++) {
            bool gpu = schedule_on_lane(s, &s->nodes[i]) && s->nodes[i].system != SCHEDULE_MERGE;
            barriers[i] = gpu ? schedule_barrier(s, &s->systems[s->nodes[i].system], state) : 0;
        }
    free(state);
    return KD_OK;
}

kd_status kd_schedule_write_dot(const kd_schedule *s, const char *path)
{
    uint32_t barriers[SCHEDULE_MAX_NODES];
    kd_file_out out;
    if (!s->built)
        return kd_fail(KD_USAGE, "%s: the graph is made by the first frame; run one before writing it", path);
    kd_status status = find_barriers(s, barriers);
    if (status == KD_OK)
        status = kd_file_out_open(&out, path);
    if (status != KD_OK)
        return status;
    fputs(
        "digraph frame {\n  rankdir=TB;\n  compound=true;\n  node [style=filled, fontname=\"sans-serif\"];\n"
        "  edge [fontname=\"sans-serif\", fontsize=10];\n",
        out.stream);
    for (int phase = 0; phase < KD_PHASE_COUNT; phase++)
        write_phase(out.stream, s, (kd_phase)phase, barriers);
    write_edges(out.stream, s, barriers);
    fputs("}\n", out.stream);
    return kd_file_out_commit(&out);
}
