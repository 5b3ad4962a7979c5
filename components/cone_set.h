#ifndef KD_COMPONENTS_CONE_SET_H
#define KD_COMPONENTS_CONE_SET_H

#include "shaders/shared/gather.h"

/** Make four sets of diffuse cones round +Z, for four neighbours that share what they find: one on the axis
 * and the others in rings (count 3 and 4: a ring alone), placed so that each set covers the hemisphere, and
 * turned against each other.
 *
 *  Shapes  out: 4 * count entries, cone i of set v at 4 i + v; w: share of the cosine-weighted hemisphere
 * that a cone stands for, 1 over a set count: 3 … KD_MAX_CONES tilt: difference of the sets' height over the
 * surface; 0: sets that are alike but for the turn Space   tangent space, the normal is +Z
 */
void kd_cone_set_make(struct kd_gl_vec4 *out, uint32_t count, float tilt, float cap_tilt);

#endif
