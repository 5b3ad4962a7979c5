/* The body: cells that triangles touch, and what these enclose. */
#include "systems/voxel_cache/geodesic.h"

#include <math.h>
#include <stdlib.h>

#include "systems/voxel_cache/fill.h"
#include "systems/voxel_cache/reference.h"

static bool lay_out(const kd_mesh_desc *mesh, float span, geodesic_body *b)
{
    kd_vec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        for (int k = 0; k < 3; k++) {
            const kd_primitive_desc *p = &mesh->primitives[i];
            (&low.x)[k] = fminf((&low.x)[k], (&p->bounds_min.x)[k]);
            (&high.x)[k] = fmaxf((&high.x)[k], (&p->bounds_max.x)[k]);
        }
    kd_vec3 extent = kd_vec3_sub(high, low);
    float longest = fmaxf(extent.x, fmaxf(extent.y, extent.z));
    b->span = fmaxf(span, longest / GEODESIC_MOST_CELLS);
    if (!(longest > 0) || !isfinite(longest) || !(b->span > 0))
        return false;
    for (int k = 0; k < 3; k++) { /* two free cells round it */
        (&b->origin.x)[k] = (floorf((&low.x)[k] / b->span) - 2) * b->span;
        b->size[k] = (uint32_t)ceilf(((&high.x)[k] - (&b->origin.x)[k]) / b->span) + 3;
    }
    return true;
}

static void mark_triangle(const geodesic_body *b, const kd_primitive_desc *p, const uint32_t *corner,
                          uint32_t *mask)
{
    double t[3][3];
    uint32_t low[3], high[3];
    for (int v = 0; v < 3; v++)
        for (int k = 0; k < 3; k++)
            t[v][k] = (double)((&p->positions[corner[v]].x)[k] - (&b->origin.x)[k]) / (double)b->span;
    for (int k = 0; k < 3; k++) {
        low[k] = (uint32_t)fmin(t[0][k], fmin(t[1][k], t[2][k]));
        high[k] = (uint32_t)fmax(t[0][k], fmax(t[1][k], t[2][k]));
    }
    for (uint32_t z = low[2]; z <= high[2]; z++)
        for (uint32_t y = low[1]; y <= high[1]; y++)
            for (uint32_t x = low[0]; x <= high[0]; x++) {
                const double from[3] = {x, y, z}, to[3] = {x + 1.0, y + 1.0, z + 1.0};
                uint32_t cell = x + b->size[0] * (y + b->size[1] * z);
                if (!(mask[cell >> 5] >> (cell & 31) & 1u) &&
                    voxel_reference_touches((const double(*)[3])t, from, to))
                    mask[cell >> 5] |= 1u << (cell & 31);
            }
}

kd_status geodesic_body_make(const kd_mesh_desc *mesh, float span, geodesic_body *body)
{
    *body = (geodesic_body){0};
    if (!lay_out(mesh, span, body))
        return KD_OK; /* flat to a point: nothing is inside */
    uint32_t count = body->size[0] * body->size[1] * body->size[2], words = count / 32 + 1;
    uint32_t *mask = calloc(words, sizeof *mask);
    body->cells = calloc(count, 1);
    kd_status status = mask && body->cells ? KD_OK : KD_NO_MEMORY;
    for (uint32_t i = 0; i < mesh->primitive_count && !status; i++)
        for (uint32_t n = 0; n + 2 < mesh->primitives[i].index_count; n += 3)
            mark_triangle(body, &mesh->primitives[i], mesh->primitives[i].indices + n, mask);
    for (uint32_t i = 0; i < count && !status; i++)
        body->cells[i] = mask[i >> 5] >> (i & 31) & 1u ? GEODESIC_SURFACE : GEODESIC_OUTSIDE;
    if (!status)
        status = fill_enclosed(mask, body->size);
    for (uint32_t i = 0; i < count && !status; i++)
        if (body->cells[i] == GEODESIC_OUTSIDE && mask[i >> 5] >> (i & 31) & 1u) {
            body->cells[i] = GEODESIC_INSIDE;
            body->inside++;
        }
    free(mask);
    if (status)
        geodesic_body_fini(body);
    return status;
}

void geodesic_body_fini(geodesic_body *body)
{
    free(body->cells);
    *body = (geodesic_body){0};
}
