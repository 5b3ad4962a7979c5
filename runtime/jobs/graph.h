#ifndef KD_JOBS_GRAPH_H
#define KD_JOBS_GRAPH_H

/* A graph of jobs, built anew each frame or run many times. Memory grows to the largest graph seen and is
 * kept: clearing, building and running one of that size allocates nothing.
 *
 *     kd_job_graph *g = kd_job_graph_make(jobs);
 *     for (;;) {
 *         kd_job_graph_clear(g);
 *         kd_job_node a = kd_job_graph_add(g, animate, scene), b = kd_job_graph_add(g, draw, scene);
 *         kd_job_graph_edge(g, a, b);
 *         if (kd_job_graph_run(g) != KD_OK) …
 *     }
 *
 * Nodes on the longest path to an end are begun first, without being told. */

#include "runtime/core/status.h"
#include "runtime/jobs/jobs.h"

typedef struct kd_job_graph kd_job_graph;
typedef uint32_t kd_job_node; /* number of the node, in order of adding */

typedef enum kd_node_place {
    KD_NODE_ANYWHERE, /* default */
    KD_NODE_FIRST,    /* before all other jobs of the pool, see kd_jobs_run_first */
    KD_NODE_LANE,     /* on the GPU lane */
} kd_node_place;

kd_job_graph *kd_job_graph_make(kd_jobs *jobs); /* NULL when memory is out */
void kd_job_graph_destroy(kd_job_graph *g);

/** Forget all nodes and edges, keep the memory. */
void kd_job_graph_clear(kd_job_graph *g);
/** Add a node that runs fn(user). When memory is out the run tells so. */
kd_job_node kd_job_graph_add(kd_job_graph *g, kd_job_fn *fn, void *user);
void kd_job_graph_place(kd_job_graph *g, kd_job_node node, kd_node_place place);
/** Let `after` begin only when `before` has ended. Two edges between the same nodes are harmless. */
void kd_job_graph_edge(kd_job_graph *g, kd_job_node before, kd_job_node after);
uint32_t kd_job_graph_count(const kd_job_graph *g);

/** Run every node once and wait for all. May be repeated; nodes must not change the graph.
 *
 *  Errors     KD_OUT_OF_RANGE for a circle and for a node that was named in an edge or a place without being
 *             there, KD_NO_MEMORY; nothing has run then
 *  Threading  one run of a graph at a time
 *  Cost       about 20 ns a node and edge more after a change, to find the order
 */
kd_status kd_job_graph_run(kd_job_graph *g);

#endif
