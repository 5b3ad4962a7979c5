#ifndef KD_CORE_FRUSTUM_H
#define KD_CORE_FRUSTUM_H

/* Six planes that bound what a camera or a shadow map sees.
 * Source  Gribb and Hartmann 2001, Fast Extraction of Viewing Frustum Planes from the World-View-Projection
 * Matrix */

#include <stdbool.h>

#include "runtime/core/math.h"

typedef struct kd_frustum {
    kd_vec4 planes[6]; /* inside where dot(xyz, p) + w >= 0; not normalised */
} kd_frustum;

/** Take the planes from a matrix whose inside is low … w on each axis after projection: low -1 for clip
 * space, 0 for texture space, given as the factor of w. */
static inline kd_frustum kd_frustum_make(const kd_mat4 *m, float low)
{
    kd_frustum f;
    const float *a = m->m;
    for (int axis = 0; axis < 3; axis++) {
        f.planes[axis * 2] = (kd_vec4){a[axis] - low * a[3], a[4 + axis] - low * a[7],
                                       a[8 + axis] - low * a[11], a[12 + axis] - low * a[15]};
        f.planes[axis * 2 + 1] =
            (kd_vec4){a[3] - a[axis], a[7] - a[4 + axis], a[11] - a[8 + axis], a[15] - a[12 + axis]};
    }
    return f;
}

/** Tell whether a box may touch the inside: its corner farthest along each plane decides. No visible box is
 * refused. */
static inline bool kd_frustum_touches(const kd_frustum *f, kd_vec3 low, kd_vec3 high)
{
    for (int i = 0; i < 6; i++) {
        const kd_vec4 *p = &f->planes[i];
        float x = p->x > 0 ? high.x : low.x, y = p->y > 0 ? high.y : low.y, z = p->z > 0 ? high.z : low.z;
        if (p->x * x + p->y * y + p->z * z + p->w < 0)
            return false;
    }
    return true;
}

#endif
