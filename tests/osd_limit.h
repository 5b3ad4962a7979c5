#ifndef KD_TESTS_OSD_LIMIT_H
#define KD_TESTS_OSD_LIMIT_H

/* OpenSubdiv's own evaluation on the CPU, by another way than our stencils take: uniform refinement, then the
 * limit of each refined vertex. */

#ifdef __cplusplus
extern "C" {
#endif

#include "runtime/asset/subdiv_shim.h"

/** Count the vertices of a cage refined `level` times and, where positions is given, write their limit (xyz
 * each). */
int osd_limit(const subdiv_cage *cage, int level, const float *cage_positions, float *positions);

#ifdef __cplusplus
}
#endif

#endif
