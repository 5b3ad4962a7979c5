#ifndef KD_SYSTEMS_CONE_TRACE_TRACERS_H
#define KD_SYSTEMS_CONE_TRACE_TRACERS_H

/* Programs of the cone tracer that trace. */

#include "components/frame.h"
#include "components/tree_access.h"

/* Every n-th pixel; listed ones without reflections; those with them. */
enum { TRACE_ALL, TRACE_LIST, TRACE_GLOSSY_LIST, TRACE_COUNT };

typedef struct gather_tracers {
    kd_tree_program programs[TRACE_COUNT][2]; /* [][1]: counting samples */
} gather_tracers;

/** Make the programs that a frame needs: those of lists, or that of all pixels. Returns false when one cannot
 * be made. */
bool tracers_fit(kd_gpu *gpu, gather_tracers *tracers, const kd_tree *tree, const kd_settings *settings,
                 bool lists, bool counts);
void tracers_destroy(kd_gpu *gpu, gather_tracers *tracers);

#endif
