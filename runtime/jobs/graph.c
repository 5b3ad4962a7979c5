/* Graphs: nodes and edges in two growing arrays; before a run the edges are sorted by their first node, so
 * that a node's successors lie side by side, those on the longest path first.
 *
 * Each node counts the predecessors that have not ended. Who ends the last one goes on with one of the nodes
 * that became free, the one with the longest way to go, and submits the others together: a chain is a loop in
 * one job. */
#include "runtime/jobs/graph.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"

enum { BATCH = 32 };

typedef struct graph_node {
    kd_job_fn *fn;
    void *user;
    kd_job_graph *graph;
    kd_node_place place;
    _Atomic uint32_t blocked;
    uint32_t need, first, count; /* predecessors; successors are next[first .. first + count) */
    uint32_t height;             /* nodes on the longest path to an end */
} graph_node;

typedef struct graph_edge {
    uint32_t before, after;
} graph_edge;

struct kd_job_graph {
    kd_jobs *jobs;
    graph_node *nodes;
    graph_edge *edges;
    uint32_t *next;  /* successors of all nodes */
    uint32_t *order; /* each node after its predecessors */
    uint32_t node_count, node_room, edge_count, edge_room, next_room, order_room;
    kd_job_node stranger; /* if misused: the first node that was named without being there, */
    uint32_t known;       /* and how many were there then */
    bool sorted, failed, misused;
    kd_job_counter unfinished;
};

/* Nodes that became free, on their way to the pool. */
typedef struct ready_batch {
    void *nodes[BATCH];
    uint32_t count;
} ready_batch;

kd_job_graph *kd_job_graph_make(kd_jobs *jobs)
{
    kd_job_graph *g = calloc(1, sizeof *g);
    if (g)
        g->jobs = jobs;
    else
        kd_fail(KD_NO_MEMORY, "job graph: no memory to make one");
    return g;
}

void kd_job_graph_destroy(kd_job_graph *g)
{
    if (!g)
        return;
    free(g->nodes);
    free(g->edges);
    free(g->next);
    free(g->order);
    free(g);
}

/* ---- building ---- */

/* Make room for `count` items of an array; what it holds stays. */
static bool reserve(kd_job_graph *g, void *array, uint32_t *room, uint32_t count, size_t size)
{
    void *old, *larger;
    if (count <= *room)
        return true;
    uint32_t wanted = *room ? *room : 64;
    while (wanted < count)
        wanted *= 2;
    memcpy(&old, array, sizeof old);
    larger = realloc(old, wanted * size);
    if (!larger) {
        g->failed = true;
        return false;
    }
    memcpy(array, &larger, sizeof larger);
    *room = wanted;
    return true;
}

void kd_job_graph_clear(kd_job_graph *g)
{
    g->node_count = g->edge_count = 0;
    g->sorted = g->failed = g->misused = false;
}

kd_job_node kd_job_graph_add(kd_job_graph *g, kd_job_fn *fn, void *user)
{
    assert(fn);
    g->sorted = false;
    if (!reserve(g, &g->nodes, &g->node_room, g->node_count + 1, sizeof *g->nodes))
        return 0;
    g->nodes[g->node_count] = (graph_node){.fn = fn, .user = user, .graph = g};
    return g->node_count++;
}

/* Is it a node? One that is not makes the run fail, unless memory is out: nodes are missing then. */
static bool is_node(kd_job_graph *g, kd_job_node node)
{
    if (node < g->node_count)
        return true;
    if (!g->misused) {
        g->stranger = node;
        g->known = g->node_count;
    }
    g->misused = true;
    g->sorted = false;
    return false;
}

void kd_job_graph_place(kd_job_graph *g, kd_job_node node, kd_node_place place)
{
    if (is_node(g, node))
        g->nodes[node].place = place;
}

void kd_job_graph_edge(kd_job_graph *g, kd_job_node before, kd_job_node after)
{
    g->sorted = false;
    if (is_node(g, before) && is_node(g, after) && !g->failed &&
        reserve(g, &g->edges, &g->edge_room, g->edge_count + 1, sizeof *g->edges))
        g->edges[g->edge_count++] = (graph_edge){before, after};
}

uint32_t kd_job_graph_count(const kd_job_graph *g)
{
    return g->node_count;
}

/* ---- sorting ---- */

static void link_successors(kd_job_graph *g)
{
    graph_node *nodes = g->nodes;
    for (uint32_t i = 0; i < g->node_count; i++)
        nodes[i].need = nodes[i].count = 0;
    for (uint32_t i = 0; i < g->edge_count; i++) {
        nodes[g->edges[i].before].count++;
        nodes[g->edges[i].after].need++;
    }
    for (uint32_t i = 0, at = 0; i < g->node_count; i++) {
        nodes[i].first = at;
        at += nodes[i].count;
        nodes[i].count = 0;
    }
    for (uint32_t i = 0; i < g->edge_count; i++) {
        graph_node *before = &nodes[g->edges[i].before];
        g->next[before->first + before->count++] = g->edges[i].after;
    }
}

/* Kahn 1962. Returns how many nodes lie on no circle and behind none. */
static uint32_t find_order(kd_job_graph *g)
{
    uint32_t end = 0;
    for (uint32_t i = 0; i < g->node_count; i++) {
        atomic_store_explicit(&g->nodes[i].blocked, g->nodes[i].need, memory_order_relaxed);
        if (g->nodes[i].need == 0)
            g->order[end++] = i;
    }
    for (uint32_t at = 0; at < end; at++) {
        const graph_node *n = &g->nodes[g->order[at]];
        for (uint32_t i = 0; i < n->count; i++) {
            graph_node *after = &g->nodes[g->next[n->first + i]];
            uint32_t left = atomic_load_explicit(&after->blocked, memory_order_relaxed) - 1;
            atomic_store_explicit(&after->blocked, left, memory_order_relaxed);
            if (left == 0)
                g->order[end++] = g->next[n->first + i];
        }
    }
    return end;
}

/* Heights from the ends back, and the highest successor of each node to the front: it is the one a worker
 * goes on with. */
static void find_heights(kd_job_graph *g)
{
    for (uint32_t at = g->node_count; at-- > 0;) {
        graph_node *n = &g->nodes[g->order[at]];
        uint32_t *next = g->next + n->first, highest = 0;
        n->height = 1;
        for (uint32_t i = 0; i < n->count; i++) {
            uint32_t height = g->nodes[next[i]].height + 1;
            if (height > n->height) {
                n->height = height;
                highest = i;
            }
        }
        if (highest) {
            uint32_t moved = next[0];
            next[0] = next[highest];
            next[highest] = moved;
        }
    }
}

static kd_status sort(kd_job_graph *g)
{
    if (g->misused && !g->failed)
        return kd_fail(KD_OUT_OF_RANGE,
                       "job graph: node %u was named when there were %u; name what kd_job_graph_add returned",
                       (unsigned)g->stranger, (unsigned)g->known);
    if (g->failed || !reserve(g, &g->next, &g->next_room, g->edge_count, sizeof *g->next) ||
        !reserve(g, &g->order, &g->order_room, g->node_count, sizeof *g->order))
        return kd_fail(KD_NO_MEMORY, "job graph: out of memory (%u nodes, %u edges); make it smaller",
                       (unsigned)g->node_count, (unsigned)g->edge_count);
    link_successors(g);
    uint32_t ordered = find_order(g);
    if (ordered < g->node_count)
        return kd_fail(KD_OUT_OF_RANGE,
                       "job graph: %u of %u nodes wait for each other in a circle; remove an edge",
                       (unsigned)(g->node_count - ordered), (unsigned)g->node_count);
    find_heights(g);
    g->sorted = true;
    return KD_OK;
}

/* ---- running ---- */

static void node_job(void *user, uint32_t worker);

static void send(kd_job_graph *g, ready_batch *ready)
{
    kd_jobs_run_n(g->jobs, node_job, ready->nodes, ready->count, NULL);
    ready->count = 0;
}

static void offer(kd_job_graph *g, ready_batch *ready, graph_node *n)
{
    if (n->place == KD_NODE_LANE) {
        kd_jobs_run_lane(g->jobs, node_job, n, NULL);
    } else if (n->place == KD_NODE_FIRST) {
        kd_jobs_run_first(g->jobs, node_job, n, NULL);
    } else {
        if (ready->count == BATCH)
            send(g, ready);
        ready->nodes[ready->count++] = n;
    }
}

/* Count one predecessor less. A lone one needs no atomic step. */
static bool unblock(graph_node *n)
{
    return n->need == 1 || atomic_fetch_sub_explicit(&n->blocked, 1, memory_order_acq_rel) == 1;
}

/* Node n has ended: free its successors. Returns the one to go on with; none after a lane node, so that other
 * lane jobs do not wait for work that could run elsewhere. */
static graph_node *release(kd_job_graph *g, const graph_node *n)
{
    ready_batch ready; /* not cleared as a whole: a hop of a chain would pay for it */
    graph_node *chosen = NULL;
    ready.count = 0;
    for (uint32_t i = 0; i < n->count; i++) {
        graph_node *next = &g->nodes[g->next[n->first + i]];
        if (!unblock(next))
            continue;
        if (!chosen && n->place != KD_NODE_LANE && next->place != KD_NODE_LANE)
            chosen = next;
        else
            offer(g, &ready, next);
    }
    if (ready.count)
        send(g, &ready);
    return chosen;
}

static void node_job(void *user, uint32_t worker)
{
    graph_node *n = user;
    kd_job_graph *g = n->graph;
    kd_jobs *jobs = g->jobs;
    uint32_t done = 0;
    for (; n; n = release(g, n)) {
        n->fn(n->user, worker);
        done++;
    }
    kd_jobs_lower(jobs, &g->unfinished, done);
}

kd_status kd_job_graph_run(kd_job_graph *g)
{
    kd_status status = g->sorted ? KD_OK : sort(g);
    if (status != KD_OK)
        return status;
    ready_batch ready = {.count = 0};
    for (uint32_t i = 0; i < g->node_count; i++)
        atomic_store_explicit(&g->nodes[i].blocked, g->nodes[i].need, memory_order_relaxed);
    atomic_store_explicit(&g->unfinished.pending, g->node_count, memory_order_relaxed);
    for (uint32_t i = 0; i < g->node_count; i++)
        if (g->nodes[i].need == 0)
            offer(g, &ready, &g->nodes[i]);
    if (ready.count)
        send(g, &ready);
    kd_jobs_wait(g->jobs, &g->unfinished);
    return KD_OK;
}
