#ifndef KD_APP_GRAPH_H
#define KD_APP_GRAPH_H

#include "runtime/ecs/system.h"

/** Tell, before any work is done, whether the graph can be written to the path. Errors with a message */
kd_status app_graph_check(const char *path);

/** Write the frame's graph as .dot, or as .svg through Graphviz. Errors with a message */
kd_status app_graph_write(const kd_schedule *s, const char *path);

#endif
