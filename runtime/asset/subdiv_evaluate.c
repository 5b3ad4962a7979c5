/* A limit surface from a posed cage, on the CPU: the same sums in the same order as
 * shaders/deform/subdivide.comp. */

#include <math.h>

#include "runtime/asset/model.h"

static kd_vec3 add_scaled(kd_vec3 sum, kd_vec3 p, float weight)
{
    return (kd_vec3){sum.x + weight * p.x, sum.y + weight * p.y, sum.z + weight * p.z};
}

/* Scaled by the largest component first, so that the derivatives of a small cage do not vanish when squared.
 */
static kd_vec3 direction(kd_vec3 v, kd_vec3 fallback)
{
    float largest = fmaxf(fabsf(v.x), fmaxf(fabsf(v.y), fabsf(v.z)));
    return largest > 1e-30f ? kd_vec3_normalize(kd_vec3_scale(v, 1 / largest), fallback) : fallback;
}

void kd_subdivision_evaluate(const kd_subdivision *s, uint32_t vertex_count, const kd_vec3 *cage,
                             kd_vec3 *positions, kd_vec3 *normals, kd_vec4 *tangents)
{
    for (uint32_t v = 0; v < vertex_count; v++) {
        const kd_stencil_row *row = &s->rows[v];
        kd_vec3 p = {0, 0, 0}, du = p, dv = p;
        for (uint32_t i = row->first; i < row->first + row->count; i++) {
            const kd_stencil *e = &s->stencils[i];
            p = add_scaled(p, cage[e->vertex], e->weight);
            du = add_scaled(du, cage[e->vertex], e->du);
            dv = add_scaled(dv, cage[e->vertex], e->dv);
        }
        positions[v] = p;
        const kd_vec3 none = {0, 0, 0};
        kd_vec3 n = direction(kd_vec3_cross(direction(du, none), direction(dv, none)), normals[v]);
        normals[v] = n;
        if (!tangents)
            continue;
        kd_vec3 t = add_scaled(kd_vec3_scale(du, row->tangent_u), dv, row->tangent_v);
        t = direction(add_scaled(t, n, -kd_vec3_dot(t, n)),
                      (kd_vec3){tangents[v].x, tangents[v].y, tangents[v].z});
        tangents[v] = (kd_vec4){t.x, t.y, t.z, tangents[v].w};
    }
}
